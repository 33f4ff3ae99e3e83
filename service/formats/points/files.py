"""Point sets from files, by their ending, for the command line."""

from pathlib import Path
from typing import Any, cast
from zipfile import BadZipFile

import numpy as np
import trimesh

from service.formats.points import decode
from service.jobs.errors import MalformedInputError
from service.jobs.fit import PointSet

TEXT = (".csv", ".txt", ".xyz", ".asc")
GEOMETRY = (".ply", ".obj", ".off", ".stl", ".glb")
# What numpy and trimesh raise on files that are not what their ending says.
UNREADABLE = (ValueError, KeyError, TypeError, IndexError, EOFError, BadZipFile)
ENDINGS = (".npy", ".npz", ".json", *TEXT, *GEOMETRY)


def read_file(path: Path, max_points: int) -> PointSet:
    """Read and check a point set.

    npy: columns are points, or points and normals. npz: arrays `points` and, if there, `normals`. JSON: as the service
    takes it. Text: numbers in columns as in an npy, with commas or blanks between, lines that begin with # or with
    letters passed over. Meshes and clouds: their vertices, with normals if the file has them.

    Raises
    ------
    InvalidInputError
        If it cannot be read or fitted; the message says why.

    """
    ending = path.suffix.lower()
    if ending in (".npy", ".json"):
        return decode.read(path, ending[1:], max_points)
    if ending not in ENDINGS:
        raise MalformedInputError(f"{path.name} does not end in one of {', '.join(ENDINGS)}")
    try:
        points, normals = _npz(path) if ending == ".npz" else _text(path) if ending in TEXT else _geometry(path)
    except UNREADABLE as error:
        raise MalformedInputError(f"{path.name} cannot be read: {error}") from error
    return decode.checked(points, normals, {}, max_points)


def _npz(path: Path) -> tuple[decode.Array, decode.Array | None]:
    with np.load(path, allow_pickle=False) as arrays:
        return arrays["points"], arrays.get("normals")


def _text(path: Path) -> tuple[decode.Array, decode.Array | None]:
    lines = path.read_text(encoding="utf-8").replace(",", " ").replace(";", " ").splitlines()
    rows = [line for line in lines if line.strip() and not (line.lstrip()[0] == "#" or line.lstrip()[0].isalpha())]
    if not rows:
        raise ValueError("there are no numbers in it")
    return decode.halves(np.loadtxt(rows, ndmin=2))


def _geometry(path: Path) -> tuple[decode.Array, decode.Array | None]:
    shape = cast("Any", trimesh.load(path, process=False, force=None))
    if isinstance(shape, trimesh.Scene):
        shape = shape.to_geometry()
    own = shape.metadata.get("vertex_normals") if isinstance(shape, trimesh.PointCloud) else _own_normals(shape)
    return np.asarray(shape.vertices), own


def _own_normals(mesh: trimesh.Trimesh) -> decode.Array | None:
    """Return normals that the file gives, or that follow from its faces; a mesh is taken to be wound outward."""
    normals = np.asarray(mesh.vertex_normals)
    return normals if len(normals) and (np.linalg.norm(normals, axis=1) > 0.0).all() else None
