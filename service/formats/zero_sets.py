"""What writes each kind of zero-set file that `service.jobs.drawing` names."""

from collections.abc import Callable

from ipcore.zero_set import ZeroSet
from service.formats import meshes, outlines

WRITERS: dict[str, Callable[[ZeroSet], bytes]] = {
    "glb": meshes.glb,
    "ply": meshes.ply,
    "stl": meshes.stl,
    "obj": meshes.obj,
    "svg": outlines.svg,
    "geojson": outlines.geojson,
}
