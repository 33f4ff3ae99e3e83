"""What can come in and go out: the kinds of point-set bodies and of zero-set files, by name and media type."""

from dataclasses import dataclass

POINT_SETS: dict[str, str] = {"application/json": "json", "application/x-npy": "npy"}


@dataclass(frozen=True)
class ZeroSetFormat:
    """A kind of zero-set file.

    Attributes
    ----------
    name
        As `?format=` says it, and the file's ending.
    dimension
        Of the fits that it can show.
    media_types
        The one it is sent as, then others that ask for it.

    """

    name: str
    dimension: int
    media_types: tuple[str, ...]


# The first of each dimension is what is sent when the caller does not care.
FILES: tuple[ZeroSetFormat, ...] = (
    ZeroSetFormat("glb", 3, ("model/gltf-binary",)),
    ZeroSetFormat("ply", 3, ("model/ply", "application/x-ply")),
    ZeroSetFormat("stl", 3, ("model/stl",)),
    ZeroSetFormat("obj", 3, ("model/obj",)),
    ZeroSetFormat("svg", 2, ("image/svg+xml",)),
    ZeroSetFormat("geojson", 2, ("application/geo+json",)),
)


@dataclass(frozen=True)
class MeshRequest:
    """How a zero set is to be drawn.

    Attributes
    ----------
    kind
        Name of the file kind.
    resolution
        Grid points along the longest axis; None lets the library choose.
    bounds
        Lower and upper corner, raw coordinates; None means the fit's own.
    restrict
        Whether to leave out what lies away from the data.

    """

    kind: str
    resolution: int | None = None
    bounds: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    restrict: bool = True
