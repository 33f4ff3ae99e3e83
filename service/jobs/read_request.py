"""How the body of a request is to be read."""

from dataclasses import dataclass

from service.jobs.media_types import Missing


@dataclass(frozen=True)
class ReadRequest:
    """How a point set is to be read.

    Attributes
    ----------
    kind
        Name of its format.
    columns
        What each column of a table or an array holds; None leaves it to the header and the rules.
    missing
        Whether a point with a value that is missing is refused or left out.
    client
        In whose turn it is read.

    """

    kind: str
    columns: str | None = None
    missing: Missing = "refuse"
    client: str = ""
