"""What a caller asks of the file of a zero set."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MeshRequest:
    """How a zero set is to be extracted and written.

    Attributes
    ----------
    format
        Name of the file format.
    resolution
        Grid points along the longest axis; None lets the library choose.
    bounds
        Lower and upper corner, raw coordinates; None means the fit's own.
    restrict
        Whether to leave out the parts of the zero set that lie away from the data.

    """

    format: str
    resolution: int | None = None
    bounds: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    restrict: bool = True
