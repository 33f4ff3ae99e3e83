"""The generalised winding number of oriented points, which tells whether a query lies inside or outside of the shape.

A closed surface fills the solid angle 4π seen from inside and 0 seen from outside; a closed curve in 2D, 2π and 0. A
sample p with outward unit normal n stands for a patch of area A, which acts like a dipole (Barill, Dickson, Schmidt,
Levin and Jacobson 2018; Jacobson, Kavan and Sorkine-Hornung 2013):

    w(q) = Σ A n·(p − q) / (4π ‖p − q‖³)        in 2D Σ A n·(p − q) / (2π ‖p − q‖²)

It varies smoothly across holes in the data, so comparing it with ½ gives the right side where the nearest normal may
not.
"""

from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from ipcore._threads import mapped
from ipcore._typing import BoolArray, FloatArray
from ipcore.points.neighbours import nearest

# Queries and points of one task for a thread. The sums of tasks are added in order, so the number of threads does not
# change the result.
TASK_QUERIES, TASK_POINTS = 8192, 16_384
# Queries and points whose distances are computed together: they (0.5 MB) stay in the L2 cache; 1.4 ns per pair in 2D,
# 2.7 in 3D.
PAIRS_BLOCK = 256
NEIGHBOURS = {2: 4, 3: 12}  # from which a point's area is estimated: two on each side of it, two rings around it
LEAST_DISTANCE = 0.25  # spacings: nearer than this a patch is no dipole; the bound keeps w finite at the samples
OPPOSED_COSINE = -0.5  # between the normals of two points, below which they face opposite ways
CHECKED_POINTS = 6000  # of the self-check
CHECKED_PROBES = 600  # of the self-check: a standard error of 0.02 at most; with CHECKED_POINTS 7e6 pairs, 0.04 s
SURFACE_WINDING = 0.5  # the winding number on the surface itself
# Spacings from a point to the places just inside and just outside of the surface. On 27 sets with 10 % of the true
# normals reversed the self-check gives 0.90–1.00 at 0.5 (a point's own dipole outweighs the rest), 0.88–0.94 at 0.7 and
# 0.87–0.93 at 1.0. With none reversed it gives at least 0.985, 0.98 and 0.95.
OFFSET = 0.7


def areas(points: FloatArray) -> FloatArray:
    """Return the area of the patch (3D) or the length of the piece of curve (2D) for which each point stands.

    The ball through the j-th neighbour, radius r_j, holds j + ½ points: the point itself, j − 1 others and half of the
    one on its boundary. So the area is A = Σ V(r_j) / Σ (j + ½) = 2 Σ V(r_j) / (k (k + 2)), summed over k neighbours,
    with V(r) = 2r in 2D and πr² in 3D. It is exact on an evenly sampled curve, and within 5 % on square and hexagonal
    grids.

    Parameters
    ----------
    points
        (N, d), in any unit of length.

    Returns
    -------
        (N,), length in 2D and area in 3D; 0 where more points coincide than there are neighbours.

    Examples
    --------
    >>> turn = 2 * np.pi * np.arange(100) / 100
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> round(float(areas(circle).sum()), 2)                          # 2π
    6.28

    """
    d = points.shape[1]
    k = min(NEIGHBOURS[d], len(points) - 1)
    return areas_within(nearest(cKDTree(points), points, k + 1)[0][:, 1:], d)  # the first is 0, the point itself


def areas_within(distances: FloatArray, d: int) -> FloatArray:
    """Return the areas (N,) of points in d dimensions, given the distances (N, ≥ k) to their neighbours, nearest first.

    >>> areas_within(np.array([[1.0, 1.0, 2.0, 2.0, 3.0, 3.0]]), 2).tolist()       # a straight line; 4 neighbours count
    [1.0]
    """
    r = distances[:, : NEIGHBOURS[d]]
    k = r.shape[1]
    V = np.pi * np.einsum("nk,nk->n", r, r) if d > 2 else 2.0 * r.sum(axis=1)
    return np.asarray(2.0 * V / (k * (k + 2)))


def oriented_areas(points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the areas (N,) as `areas` does, but without the neighbours on the opposite side of a thin part.

    The two sides of a thin part together look like one surface with twice as many points. So where a neighbour faces
    the other way, the areas are those of the points among the nearest 3 k that face the same way.

    >>> line = np.column_stack([np.arange(50.0), np.zeros(50)])
    >>> up = np.tile([0.0, 1.0], (50, 1))
    >>> plate = np.vstack([line, line - [0.5, 0.1]])
    >>> [float(np.median(A).round(2)) for A in (areas(plate), oriented_areas(plate, np.vstack([up, -up])))]
    [0.5, 1.0]
    """
    d = points.shape[1]
    k = min(NEIGHBOURS[d], len(points) - 1)
    tree = cKDTree(points)
    distances, indices = nearest(tree, points, k + 1)
    A = areas_within(distances[:, 1:], d)
    opposed = np.einsum("nkd,nd->nk", normals[indices[:, 1:]], normals) < OPPOSED_COSINE
    thin = np.flatnonzero(opposed.any(axis=1))
    if not len(thin):
        return A
    distances, indices = nearest(tree, points[thin], min(3 * k, len(points) - 1) + 1)
    same = np.einsum("nkd,nd->nk", normals[indices], normals[thin]) >= OPPOSED_COSINE
    r = np.sort(np.where(same, distances, np.inf), axis=1)[:, 1 : k + 1]
    enough = np.isfinite(r).all(axis=1)
    A[thin[enough]] = areas_within(r[enough], d)
    return A


def winding_number(queries: FloatArray, points: FloatArray, normals: FloatArray, areas: FloatArray) -> FloatArray:
    """Return w(q), about 1 inside and 0 outside the shape.

    With u = ‖p − q‖⁻ᵈ the sum is Σ u A n·p − q·Σ u A n: one matrix product for ‖p − q‖², one with u. Time is O(M N),
    memory O(M + N).

    Parameters
    ----------
    queries
        (M, d).
    points
        (N, d), in the unit and frame of `queries`.
    normals
        (N, d), unit, outward.
    areas
        (N,), see `areas`.

    Returns
    -------
        (M,)

    Examples
    --------
    >>> turn = 2 * np.pi * np.arange(100) / 100
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> w = winding_number(np.array([[0.3, 0.2], [2.0, 0.0]]), circle, circle, areas(circle))
    >>> (w > 0.5).tolist()
    [True, False]

    """
    d = points.shape[1]
    centre = points.mean(axis=0)  # near the origin the squares below lose the fewest digits
    p, q = points - centre, queries - centre
    dipoles = areas[:, None] * normals / (2.0 * np.pi * (d - 1))
    floor = (LEAST_DISTANCE * areas ** (1.0 / (d - 1))) ** 2
    floor = np.maximum(floor, np.finfo(float).tiny ** 0.25)  # for points that coincide: their areas are 0
    left = np.column_stack([(q**2).sum(axis=1), np.ones(len(q)), -2.0 * q])
    right = np.vstack([np.ones(len(p)), (p**2).sum(axis=1), p.T])
    potential = np.column_stack([(dipoles * p).sum(axis=1), -dipoles])
    tasks = list(product(_slices(len(q), TASK_QUERIES), _slices(len(p), TASK_POINTS)))
    sums = mapped(lambda task: _sums(left[task[0]], right[:, task[1]], floor[task[1]], potential[task[1]]), tasks)
    total = np.zeros((len(q), d + 1))
    for (rows, _), part in zip(tasks, sums, strict=True):
        total[rows] += part
    return np.asarray(total[:, 0] + (q * total[:, 1:]).sum(axis=1))


def _slices(length: int, step: int) -> list[slice]:
    """Return slices of `step` rows that cover `length` rows; the last one may reach farther."""
    return [slice(start, start + step) for start in range(0, length, step)]


def _sums(left: FloatArray, right: FloatArray, floor: FloatArray, potential: FloatArray) -> FloatArray:
    """Return Σ u (A n·p, −A n) over P points, for M queries, (M, d + 1).

    `left` (M, d + 2) times `right` (d + 2, P) are the squared distances, `floor` (P,) their least values, and
    `potential` (P, d + 1) the terms (A n·p, −A n).
    """
    sums = np.zeros((len(left), potential.shape[1]))
    scratch = np.empty(PAIRS_BLOCK**2)
    for here, there in product(_slices(len(left), PAIRS_BLOCK), _slices(len(floor), PAIRS_BLOCK)):
        queries, points = left[here], right[:, there]
        u = scratch[: len(queries) * points.shape[1]].reshape(len(queries), -1)
        np.maximum(np.matmul(queries, points, out=u), floor[there], out=u)
        if sums.shape[1] == 4:
            u *= np.sqrt(u)
        sums[here] += np.reciprocal(u, out=u) @ potential[there]
    return sums


def self_check(points: FloatArray, normals: FloatArray) -> float:
    """Return the share of points with w > ½ just inside and w < ½ just outside: how far the normals are consistent.

    Where the shape is thinner than the distance from a point to these two places, they may both be outside. A point
    whose neighbour on the opposite side faces away from it is consistent with that one, and counts without the winding
    number.

    A share below about 0.9 means that many normals point inward, or that the points bound no volume: near a plane w
    need not be above ½ on one side. Where a large patch is reversed as a whole, the share is too high, for the patch is
    like the wall of a hole. The share is estimated on a fixed random subset, 600 points against 6,000, so that the cost
    does not grow with N. With 60,000 points, 0 to 10 % of whose normals were reversed, that differed from the share of
    all points by at most 0.008, with 20 % by 0.02.

    Parameters
    ----------
    points
        (N, d), in any unit of length.
    normals
        (N, d), unit.

    Returns
    -------
        Between 0 and 1.

    Examples
    --------
    >>> turn = 2 * np.pi * np.arange(100) / 100
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> self_check(circle, circle), self_check(circle, -circle)
    (1.0, 0.0)

    """
    rng = np.random.default_rng(0)  # seeded: the same points get the same share
    some = rng.permutation(len(points))[:CHECKED_POINTS]
    p, n = points[some], normals[some]
    A = oriented_areas(p, n)
    step = OFFSET * A[:CHECKED_PROBES, None] ** (1.0 / (points.shape[1] - 1)) * n[:CHECKED_PROBES]
    probes = np.concatenate([p[:CHECKED_PROBES] - step, p[:CHECKED_PROBES] + step])
    inside, outside = winding_number(probes, p, n, A).reshape(2, -1)
    consistent = (inside > SURFACE_WINDING) & (outside < SURFACE_WINDING)
    return float((consistent | _on_thin_part(p, n, step)).mean())


def _on_thin_part(p: FloatArray, n: FloatArray, step: FloatArray) -> BoolArray:
    """Return which of the first M points have the opposite side of a thin part within a step, behind them, (M,).

    `p` and `n` (N, d) are the points and their normals, `step` (M, d) the steps from the first M of them to outside.
    The opposite side is that of the nearest point that faces the other way, if each of the two is behind the plane of
    the other one. A point whose normal is wrong is in front of or behind its neighbours' planes as they are of its own.
    """
    m, k = len(step), min(3 * NEIGHBOURS[p.shape[1]], len(p) - 1)
    indices = nearest(cKDTree(p), p[:m], k + 1)[1]
    opposed = np.einsum("mkd,md->mk", n[indices], n[:m]) < OPPOSED_COSINE
    first = indices[np.arange(m), opposed.argmax(axis=1)]
    across = p[first] - p[:m]
    behind, depth = (across * n[:m]).sum(axis=1) < 0.0, (across * n[first]).sum(axis=1)
    return np.asarray(opposed.any(axis=1) & behind & (depth > 0.0) & (depth < np.linalg.norm(step, axis=1)))
