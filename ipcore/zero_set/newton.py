"""Newton's method, which moves the vertices of an extracted mesh onto f = 0, and the normals there."""

from dataclasses import replace
from functools import partial

import numpy as np

from ipcore._threads import by_rows
from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.mesh import Mesh, cell_vectors

# At 96³ and degree 12, marching cubes leaves a median |f|/‖∇f‖ of 1e-4 mean radii and at worst 1e-3; the steps take
# these to 7e-9 and 5e-6, 4e-16 and 1e-10, 1e-16 and 4e-15.
NEWTON_STEPS = 3
# A vertex is not moved again after a step shorter than this many grid steps h: what remains of its distance from the
# zero set is κh/2 · 1e-14 h, with κ the curvature.
LAST_STEP = 1e-7


def polish(
    mesh: Mesh, polynomial: ImplicitPolynomial, bounds: FloatArray, spacing: float, threads: int | None = None
) -> Mesh:
    """Return the mesh after `NEWTON_STEPS` steps v ← v − f g/‖g‖², g being ∇f with 0 for the held coordinates.

    No step is longer than half the `spacing` of the grid (raw), leaves the bounds (2, d) or flips a cell: where a step
    would flip one (near singular points), the vertices of that cell stay.
    """
    v, moving = mesh.vertices, np.flatnonzero(~mesh.held.all(axis=1))
    for _ in range(NEWTON_STEPS):
        x = v.take(moving, axis=0)
        step = by_rows(partial(_step, polynomial, x, mesh.held.take(moving, axis=0)), len(x), threads)
        length = np.sqrt(np.einsum("vk,vk->v", step, step))
        step *= (0.5 * spacing / np.maximum(length, 0.5 * spacing))[:, None]
        moved = v.copy()
        moved[moving] = np.clip(x + step, *bounds)
        v = _unflipped(v, moved, _touching(mesh.cells, moving, len(v)), threads)
        moving = moving[length > LAST_STEP * spacing]
    return replace(mesh, vertices=v)


def unit_normals(
    mesh: Mesh, polynomial: ImplicitPolynomial, bounds: FloatArray, threads: int | None = None
) -> FloatArray:
    """Return ∇f/‖∇f‖ at the vertices, (V, d); within a cap the outward normal of its walls; 0 where ∇f vanishes.

    `bounds` (2, d), raw, are those of the box by whose walls the mesh was cut.
    """
    direction = by_rows(lambda part: polynomial.gradient(mesh.vertices[part]), len(mesh.vertices), threads)
    within = mesh.held.all(axis=1)
    wall = mesh.vertices[within]
    direction[within] = (wall == bounds[1]).astype(float) - (wall == bounds[0])
    return _unit(direction)


def onto_zero_set(polynomial: ImplicitPolynomial, x: FloatArray, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Return points x (n, d), raw, moved onto f = 0 as `polish` moves vertices, and ∇f/‖∇f‖ there, (n, d) both.

    The normal is 0 where ∇f vanishes.

    >>> from ipcore import shapes
    >>> x, normals = onto_zero_set(shapes.circle().polynomial, np.array([[1.1, 0.0]]), 0.5)
    >>> x.round(9).tolist(), normals.round(9).tolist()
    ([[1.0, 0.0]], [[1.0, 0.0]])
    """
    free = np.zeros(x.shape, dtype=bool)
    for _ in range(NEWTON_STEPS):
        step = _step(polynomial, x, free, slice(None))
        length = np.linalg.norm(step, axis=1)
        x = x + step * (0.5 * spacing / np.maximum(length, 0.5 * spacing))[:, None]
    return x, _unit(polynomial.gradient(x))


def _unit(direction: FloatArray) -> FloatArray:
    """Return vectors (n, d) scaled to length 1; 0 stays."""
    length = np.sqrt(np.einsum("vk,vk->v", direction, direction))[:, None]
    return np.asarray(np.divide(direction, length, out=np.zeros_like(direction), where=length > 0.0))


def _step(polynomial: ImplicitPolynomial, x: FloatArray, held: BoolArray, part: slice) -> FloatArray:
    """Return the Newton steps (p, d) at the p points of x (n, d) in a slice.

    A step is 0 along the coordinates marked in `held` (n, d), and where the gradient vanishes.
    """
    f, g = polynomial.value_and_gradient(x[part])
    g = np.where(held[part], 0.0, g)
    square = np.einsum("vk,vk->v", g, g)
    return np.asarray(g * np.divide(-f, square, out=np.zeros_like(f), where=square > 0.0)[:, None])


def _touching(cells: IntArray, some: IntArray, vertices: int) -> IntArray:
    """Return the cells (T, d) of `cells` (C, d) that have a vertex whose number is in `some` (n,), of V, `vertices`."""
    mark = np.zeros(vertices, dtype=bool)
    mark[some] = True
    return cells[np.logical_or.reduce([mark[corner] for corner in cells.T])]


def _unflipped(before: FloatArray, moved: FloatArray, cells: IntArray, threads: int | None) -> FloatArray:
    """Return the moved vertices (V, d), with those of flipped cells put back to `before` (V, d), until none is flipped.

    `cells` (C, d) are the cells with a moved vertex.
    """
    while True:
        turn = by_rows(partial(_turn, before, moved, cells), len(cells), threads)
        back = np.unique(cells[turn < 0.0])
        back = back[(moved[back] != before[back]).any(axis=1)]
        if not len(back):
            return moved
        moved[back] = before[back]
        cells = _touching(cells, back, len(moved))


def _turn(before: FloatArray, after: FloatArray, cells: IntArray, part: slice) -> FloatArray:
    """Return the products (p,) of the normals before and after of the p cells in a slice: negative where one flips.

    `before` and `after` are the vertices (V, d).
    """
    return np.asarray(np.einsum("ck,ck->c", cell_vectors(before, cells[part]), cell_vectors(after, cells[part])))
