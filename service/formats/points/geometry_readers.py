"""The readers of geometry files by kind."""

from collections.abc import Callable

from service.formats.points.obj import read_obj
from service.formats.points.off import read_off
from service.formats.points.ply import read_ply
from service.formats.points.reading import RawPoints, ReadOptions
from service.formats.points.stl_glb import read_glb, read_stl

GEOMETRY_READERS: dict[str, Callable[[bytes, ReadOptions], RawPoints]] = {
    "ply": read_ply,
    "obj": read_obj,
    "off": read_off,
    "stl": read_stl,
    "glb": read_glb,
}
