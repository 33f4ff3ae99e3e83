"""A file that was made of a fit: its zero set, or its points."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ExportedFile:
    """A file that was made of a fit.

    Attributes
    ----------
    path
        Where it is, until it is released.
    release
        Called, once, by who has read it, or does not want to.
    encoding
        How it is compressed, as in Content-Encoding; None if it is not.
    warning
        An ASCII sentence that says that the grid of the zero set was too coarse, and what helps; None if it was not.

    """

    path: Path
    release: Callable[[], None]
    encoding: str | None = None
    warning: str | None = None
