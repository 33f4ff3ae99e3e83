"""The file formats of point sets and zero sets.

This is the one list: the OpenAPI document, content negotiation, the command line and the writers are derived from it.
"""

from dataclasses import dataclass
from typing import Literal

# Whether a point with a value that is missing is refused or left out.
Missing = Literal["refuse", "drop"]


@dataclass(frozen=True)
class PointSetFormat:
    """A format of point sets in the body of a request.

    Attributes
    ----------
    name
        As in `?format=`.
    media_type
        As in Content-Type.

    """

    name: str
    media_type: str


@dataclass(frozen=True)
class ZeroSetFormat:
    """A file format of zero sets. `service.formats.zero_set` has a module of the same name that writes it.

    Attributes
    ----------
    name
        As in `?format=`, and the ending of the file.
    dimension
        Of the fits whose zero sets it can hold.
    media_types
        The first is the one that is sent; the others are accepted in requests as well.

    """

    name: str
    dimension: int
    media_types: tuple[str, ...]


JSON = PointSetFormat("json", "application/json")
POINT_SET_FORMATS = (JSON, PointSetFormat("npy", "application/x-npy"), PointSetFormat("csv", "text/csv"))
# The first of each dimension is sent to a caller who does not name a format.
ZERO_SET_FORMATS = (
    ZeroSetFormat("glb", 3, ("model/gltf-binary",)),
    ZeroSetFormat("ply", 3, ("model/ply", "application/x-ply")),
    ZeroSetFormat("stl", 3, ("model/stl",)),
    ZeroSetFormat("obj", 3, ("model/obj",)),
    ZeroSetFormat("svg", 2, ("image/svg+xml",)),
    ZeroSetFormat("geojson", 2, ("application/geo+json",)),
)


def zero_set_formats(dimension: int) -> list[ZeroSetFormat]:
    """Return the formats for fits of this dimension.

    >>> [known.name for known in zero_set_formats(2)]
    ['svg', 'geojson']
    """
    return [known for known in ZERO_SET_FORMATS if known.dimension == dimension]
