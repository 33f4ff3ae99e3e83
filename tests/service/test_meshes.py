"""Mesh files, read back by trimesh."""

import json
from io import BytesIO

import numpy as np
import pytest
import trimesh

from ipcore import shapes
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.zero_set import ZeroSet, zero_set
from service.formats.zero_set import glb, stl
from service.formats.zero_set.writers import WRITERS
from service.jobs.media_types import ZERO_SET_FORMATS, zero_set_formats

NAMES = [known.name for known in zero_set_formats(3)]
SINGLE, DOUBLE = float(np.finfo(np.float32).eps), float(np.finfo(float).eps)


def torus(shift: float = 0.0, scale: float = 1.0) -> ZeroSet:
    p = shapes.torus().polynomial
    moved = ImplicitPolynomial(p.degree, p.coefficients, Frame(p.frame.centre + shift, scale), scale * p.bounds + shift)
    return zero_set(moved, resolution=32)


def write(z: ZeroSet, name: str) -> bytes:
    return WRITERS[name](z)


def read(data: bytes, name: str) -> trimesh.Trimesh:
    """Return the one mesh of a file, moved to where its node is; trimesh's own `load_mesh` would drop the normals."""
    scene = trimesh.load_scene(BytesIO(data), file_type=name, process=False, maintain_order=True)
    (node,) = scene.graph.nodes_geometry
    placed, geometry = scene.graph[node]
    stored = scene.geometry[geometry]
    vertices = stored.vertices @ placed[:3, :3].T + placed[:3, 3]
    return trimesh.Trimesh(vertices, stored.faces, vertex_normals=stored.vertex_normals, process=False)


def volume(z: ZeroSet) -> float:
    return float(trimesh.Trimesh(z.vertices, z.cells, process=False).volume)


@pytest.mark.parametrize("name", NAMES)
def test_every_format_opens_again_with_the_same_surface(name: str) -> None:
    z = torus()
    mesh = read(write(z, name), name)
    assert len(mesh.faces) == len(z.cells)
    assert np.abs(mesh.triangles - z.vertices[z.cells]).max() <= 2.0 * SINGLE
    assert mesh.volume == pytest.approx(volume(z), rel=1e-5)
    mesh.merge_vertices(merge_norm=True)  # STL keeps no connections
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 0


@pytest.mark.parametrize("name", ["glb", "ply", "obj"])
def test_formats_with_shared_vertices_keep_their_order_and_normals(name: str) -> None:
    z = torus()
    mesh = read(write(z, name), name)
    assert (mesh.faces == z.cells).all()
    assert np.abs(mesh.vertex_normals - z.normals).max() < 2.0 * SINGLE


@pytest.mark.parametrize("name", ["ply", "obj"])
@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_formats_in_double_precision_lose_nothing(name: str, shift: float) -> None:
    z = torus(shift)
    assert (read(write(z, name), name).vertices == z.vertices).all()


def test_glb_keeps_single_precision_of_the_size_however_far_from_the_origin() -> None:
    z = torus(shift=1e6, scale=0.37)
    mesh = read(glb.write(z), "glb")
    assert np.abs(mesh.vertices - z.vertices).max() < SINGLE + DOUBLE * 1e6
    assert mesh.volume == pytest.approx(volume(torus()) * 0.37**3, rel=1e-5)


def test_glb_says_what_its_numbers_mean() -> None:
    data = glb.write(torus(shift=1e6))
    tree = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    assert tree["asset"]["extras"] == glb.GLB_NOTES
    assert tree["nodes"][0]["matrix"][12:15] == pytest.approx([1e6] * 3, abs=0.1)
    position = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    assert np.abs(position["max"]).max() < 2.0


def test_stl_has_unit_face_normals_that_face_outward() -> None:
    z = torus()
    data = stl.write(z)
    assert len(data) == 84 + 50 * len(z.cells)
    normals = read(data, "stl").face_normals
    assert np.abs(np.linalg.norm(normals, axis=1) - 1.0).max() < 1e-6
    assert ((normals * z.normals[z.cells].mean(axis=1)).sum(axis=1) > 0.8).all()


@pytest.mark.parametrize("name", NAMES)
def test_no_surface_is_a_file_with_no_faces(name: str) -> None:
    nothing = zero_set(shapes.sphere().polynomial, np.array([[2.0] * 3, [3.0] * 3]), 4)
    data = write(nothing, name)
    assert isinstance(data, bytes)
    assert len(data) > 0


def test_every_kind_that_is_offered_has_its_writer() -> None:
    assert list(WRITERS) == [known.name for known in ZERO_SET_FORMATS]
    types = [media_type for known in ZERO_SET_FORMATS for media_type in known.media_types]
    assert len(set(types)) == len(types)
