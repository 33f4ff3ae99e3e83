"""What writes each kind of zero-set file that `service.jobs.media_types` names."""

from collections.abc import Callable

from ipcore.zero_set.zero_set import ZeroSet
from service.formats.zero_set import curves, meshes

WRITERS: dict[str, Callable[[ZeroSet], bytes]] = {
    "glb": meshes.glb,
    "ply": meshes.ply,
    "stl": meshes.stl,
    "obj": meshes.obj,
    "svg": curves.svg,
    "geojson": curves.geojson,
}
