"""The file of a zero set, with what its reader should know."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ZeroSetFile:
    """A file that an exporter has made.

    Attributes
    ----------
    content
        The bytes of the file.
    warning
        An ASCII sentence that says that the grid was too coarse, and what helps; None if it was fine enough.

    """

    content: bytes
    warning: str | None = None
