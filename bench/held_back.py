"""Test shapes that no constant was tuned on: outlines of letters, level sets of Gaussians, and solids, all made here.

The letters come with matplotlib (DejaVu Sans and Serif), the solids with trimesh; the rest are fixed seeds. They
were chosen before any fit was made of them. Do not tune a constant on them; other shapes would be needed then.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from matplotlib import get_data_path
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from numpy.typing import NDArray
from skimage.measure import marching_cubes

from sets import FloatArray, PointSet

LETTERS = {"Sans": "CGHLSTWZ237*", "Serif": "JKUX5{"}
NAMES = {"*": "asterisk", "{": "brace"}
OUTLINE_POINTS, SURFACE_POINTS = 600, 4000
BLOBS = (1, 2, 3)  # seeds
# Halfway between two centres the sum is at least 2 exp(-STEP² / (8 WIDTH²)) = 0.9 > LEVEL, so the surface is connected.
LEVEL, WIDTH, STEP = 0.5, 0.4, 1.0
SOLIDS: dict[str, Callable[[], trimesh.Trimesh]] = {
    "capsule": lambda: trimesh.creation.capsule(height=2.0, radius=0.6, count=[96, 96]),
    "cone": lambda: trimesh.creation.cone(radius=1.0, height=2.0, sections=256),
    "ring": lambda: trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=0.6, sections=256),
}


def shapes() -> list[PointSet]:
    """Return all of them, outlines first."""
    letters = [letter(font, glyph) for font, glyphs in LETTERS.items() for glyph in glyphs]
    return [*letters, *map(blob, BLOBS), *map(solid, SOLIDS)]


def letter(font: str, glyph: str) -> PointSet:
    """Return the outline of a glyph without holes, evenly spaced and in order, with its outward normals."""
    file = Path(get_data_path()) / "fonts" / "ttf" / f"DejaVu{font}.ttf"
    (outline,) = TextPath((0.0, 0.0), glyph, size=1000, prop=FontProperties(fname=file)).to_polygons()
    corners = np.array(outline, dtype=float)
    ahead = np.diff(corners, axis=0)
    lengths = np.linalg.norm(ahead, axis=1)
    corners, ahead, lengths = corners[:-1][lengths > 0.0], ahead[lengths > 0.0], lengths[lengths > 0.0]
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    at = (np.arange(OUTLINE_POINTS) + 0.5) * starts[-1] / OUTLINE_POINTS
    side = np.searchsorted(starts, at, side="right") - 1
    tangents = (ahead / lengths[:, None])[side]
    twice_area = np.sum(corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0])
    normals = np.sign(twice_area) * np.column_stack([tangents[:, 1], -tangents[:, 0]])
    points = corners[side] + (at - starts[side])[:, None] * tangents
    return PointSet(f"{font} {NAMES.get(glyph, glyph)}", points, normals, closed=True)


def blob(seed: int) -> PointSet:
    """Return a level set of five Gaussians, each one step away from an earlier one, with its gradient's normals."""
    generator = np.random.default_rng(seed)
    centres = np.zeros((1, 3))
    for _ in range(4):
        direction = generator.normal(size=3)
        origin = centres[generator.integers(len(centres))]
        centres = np.vstack([centres, origin + STEP * direction / np.linalg.norm(direction)])
    low, high = centres.min(axis=0) - 1.0, centres.max(axis=0) + 1.0  # where the sum is below 5 exp(-3.1) < LEVEL
    lines = [np.linspace(a, b, 128) for a, b in zip(low, high, strict=True)]
    squares = [[(line - x) ** 2 for line, x in zip(lines, centre, strict=True)] for centre in centres]
    one = [[np.exp(-square / (2.0 * WIDTH**2)) for square in of] for of in squares]
    density = np.sum([np.einsum("i,j,k->ijk", *of) for of in one], axis=0)
    spacing = tuple(float(line[1] - line[0]) for line in lines)
    vertices, faces, *_ = marching_cubes(density, LEVEL, spacing=spacing)
    points, _ = drawn(trimesh.Trimesh(vertices + low, faces), seed)
    away = points[:, None] - centres
    normals = np.sum(away * np.exp(-np.square(away).sum(axis=2) / (2.0 * WIDTH**2))[..., None], axis=1)
    return PointSet(f"blob {seed}", points, normals / np.linalg.norm(normals, axis=1)[:, None], closed=True)


def solid(name: str) -> PointSet:
    """Return random points of a solid of trimesh, with the normals of their faces."""
    mesh = SOLIDS[name]()
    points, face = drawn(mesh, 0)
    return PointSet(name, points, np.array(mesh.face_normals[face]), closed=True)


def drawn(mesh: trimesh.Trimesh, seed: int) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return points drawn evenly from a mesh, and their faces."""
    points, face = trimesh.sample.sample_surface(mesh, SURFACE_POINTS, seed=seed)
    return np.array(points), np.array(face, dtype=np.intp)
