"""The table of formats that a zero set can be had in."""

from collections.abc import Callable
from dataclasses import dataclass
from fnmatch import fnmatchcase

from ipcore.zero_set import ZeroSet
from service.formats import meshes, outlines


@dataclass(frozen=True)
class ZeroSetFormat:
    """How a zero set becomes a file.

    Attributes
    ----------
    name
        What `?format=` says, and the file's suffix.
    media_types
        What `Accept` may say; the first is what `Content-Type` says.
    dimension
        2 for curves, 3 for surfaces.
    write
        The writer; it takes zero sets of this dimension only.

    """

    name: str
    media_types: tuple[str, ...]
    dimension: int
    write: Callable[[ZeroSet], bytes]


FORMATS = (  # of each dimension the first is the default
    ZeroSetFormat("glb", ("model/gltf-binary",), 3, meshes.glb),
    ZeroSetFormat("ply", ("model/ply", "application/x-ply"), 3, meshes.ply),
    ZeroSetFormat("stl", ("model/stl",), 3, meshes.stl),
    ZeroSetFormat("obj", ("model/obj",), 3, meshes.obj),
    ZeroSetFormat("svg", ("image/svg+xml",), 2, outlines.svg),
    ZeroSetFormat("geojson", ("application/geo+json",), 2, outlines.geojson),
)


def by_name(name: str) -> ZeroSetFormat | None:
    """Return the format of a name, in whatever case; None if there is none.

    >>> by_name("PLY").media_types
    ('model/ply', 'application/x-ply')
    """
    return next((known for known in FORMATS if known.name == name.lower()), None)


def by_media_type(dimension: int, media_range: str) -> ZeroSetFormat | None:
    """Return the first format of a dimension that a media range of `Accept`, without its parameters, allows.

    >>> by_media_type(3, "model/*").name, by_media_type(2, "*/*").name, by_media_type(2, "model/stl")
    ('glb', 'svg', None)
    """
    wanted = media_range.strip().lower()
    fitting = (known for known in FORMATS if known.dimension == dimension)
    return next((known for known in fitting if any(fnmatchcase(t, wanted) for t in known.media_types)), None)


WRITERS = {known.name: known.write for known in FORMATS}
