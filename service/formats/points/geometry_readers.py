"""The readers of geometry files by kind."""

from collections.abc import Callable

from service.formats.points.obj import read_obj
from service.formats.points.off import read_off
from service.formats.points.ply import read_ply
from service.formats.points.reading import RawPoints, ReadOptions


def _read_stl(content: bytes, options: ReadOptions) -> RawPoints:
    from service.formats.points.stl_glb import read_stl  # noqa: PLC0415 - loads trimesh, which takes half a second

    return read_stl(content, options)


def _read_glb(content: bytes, options: ReadOptions) -> RawPoints:
    from service.formats.points.stl_glb import read_glb  # noqa: PLC0415 - as above

    return read_glb(content, options)


GEOMETRY_READERS: dict[str, Callable[[bytes, ReadOptions], RawPoints]] = {
    "ply": read_ply,
    "obj": read_obj,
    "off": read_off,
    "stl": _read_stl,
    "glb": _read_glb,
}
