"""Point sets from files, by their ending, for the command line."""

from pathlib import Path

from service.formats.points import decode
from service.jobs.errors import MalformedInputError
from service.jobs.fit import ReceivedPoints
from service.jobs.media_types import Missing

ENDINGS = tuple(f".{kind}" for kind in decode.READERS)


def read_file(
    path: Path, max_points: int, *, columns: str | None = None, missing: Missing = "refuse"
) -> ReceivedPoints:
    """Read and check the point set in a file of the kind that its ending names; see `decode.read`.

    Raises
    ------
    InvalidInputError
        If it cannot be read or fitted; the message says why.

    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise MalformedInputError(f"{path.name} does not end in one of {', '.join(ENDINGS)}")
    return decode.read(path, ending[1:], max_points, columns=columns, missing=missing)
