"""From oriented points to a mesh: ipfit, SciPy's RBFInterpolator, and Open3D's Poisson reconstruction if installed."""

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skimage.measure import marching_cubes

import ipcore
from contest import clouds, poisson
from contest.clouds import Cloud
from contest.fitting import TOP
from contest.process import Asked, alone
from contest.rounds import Medians, Scores, how_many, interleaved
from contest.trial import Contender, Trial
from evidence.table import table
from ipcore.constraints.family import RowParameters
from ipcore.constraints.three_layer import ThreeLayer
from sets import FloatArray

COUNT = 3000  # points: an RBF takes three centres for each
GRID = 64  # lines along the longest axis, of the RBF; ipfit's mesh has its own default
NEIGHBOURS = 30  # of the RBF: with all 9,000 centres at once it would solve for as many unknowns
LAYER, MARGIN = 0.05, 0.3  # mean radii: the outer layers, and the box round the points, as ipfit has them
CANDIDATES = 12  # triangles, by their middles, among which the nearest to a point is looked for
FAR = 0.1  # mean radii from all points, where a triangle counts as stray

Surface = tuple[FloatArray, NDArray[np.integer[Any]]]  # vertices (V, 3) and triangles (T, 3)


def by_ipfit(cloud: Cloud, **options: Any) -> Surface:  # noqa: ANN401 - whatever `FitOptions.of` takes
    """Fit, and take the zero set near the points."""
    fit = ipcore.fit(cloud.points, cloud.normals, ipcore.FitOptions.of(measure_zero_set=False, **options))
    found = ipcore.zero_set(fit.polynomial, data=cloud.points, cap=False)
    return found.vertices, found.cells


def by_rbf(cloud: Cloud) -> Surface:
    """Interpolate three layers, evaluate on a grid, and march."""
    frame = ipcore.Frame.of(cloud.points)
    x = frame.to_local(cloud.points)
    rows = ThreeLayer().rows(x, cloud.normals, RowParameters(LAYER, 0.0))
    centres = np.concatenate([group.positions for group in rows.groups])
    low, high = x.min(axis=0) - MARGIN, x.max(axis=0) + MARGIN
    step = (high - low).max() / (GRID - 1)
    axes = [np.arange(a, b + step, step) for a, b in zip(low, high, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    f = RBFInterpolator(centres, rows.b(1), neighbors=NEIGHBOURS)(nodes.reshape(-1, 3)).reshape(nodes.shape[:-1])
    vertices, faces, *_ = marching_cubes(f, 0.0, spacing=(step,) * 3)
    return frame.to_raw(vertices + low), faces


WAYS: dict[str, Callable[[Cloud], Surface]] = {
    "ipfit, default": by_ipfit,
    f"ipfit, linear to degree {TOP}": partial(by_ipfit, geometric=False, max_degree=TOP),
    f"SciPy RBFInterpolator, {NEIGHBOURS} neighbours, {GRID}³": by_rbf,
}


def contender(way: str) -> Contender:
    """Return a way as what a process runs."""

    def ready(folder: Path) -> Trial:
        cloud, work = Cloud.load(folder, "solid"), WAYS[way]
        few = cloud.first(COUNT // 10)

        def judged(found: Surface) -> dict[str, Any]:
            np.savez(folder / f"{way}.npz", vertices=found[0], faces=found[1])
            return {}

        warm = few if work is not by_rbf else None
        return Trial(lambda: warm and work(warm), lambda: work(cloud), judged)

    return ready


CONTENDERS = {way: contender(way) for way in WAYS}


def closeness(surface: Surface, cloud: Cloud) -> dict[str, float]:
    """Return the mean distance of the points from a mesh, the mean cosine of its normals there, and what is stray."""
    vertices, faces = surface
    scale = ipcore.Frame.of(cloud.points).scale
    corners = vertices[faces]
    middles = corners.mean(axis=1)
    near = np.asarray(cKDTree(middles).query(cloud.points, k=CANDIDATES)[1])
    on = trimesh.triangles.closest_point(  # type: ignore[no-untyped-call] # trimesh leaves it unannotated
        corners[near.ravel()], np.repeat(cloud.points, CANDIDATES, axis=0)
    )
    away = np.linalg.norm(on.reshape(-1, CANDIDATES, 3) - cloud.points[:, None], axis=2)
    nearest = near[np.arange(len(near)), away.argmin(axis=1)]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(area, np.finfo(float).tiny)[:, None]
    far = cKDTree(cloud.points).query(middles)[0] > FAR * scale
    return {
        "d_dist": float(away.min(axis=1).mean()) / scale,
        "d_smooth": float(np.einsum("nk,nk->n", normal[nearest], cloud.normals).mean()),
        "stray": float(area[far].sum() / area.sum()),
        "pieces": _pieces(faces, len(vertices)),
        "triangles": len(faces),
    }


def _pieces(faces: NDArray[np.integer[Any]], count: int) -> int:
    """Return how many connected pieces the triangles make."""
    i, j = faces.ravel(), np.roll(faces, 1, axis=1).ravel()
    labels = connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(count, count)), directed=False)[1]
    return len(np.unique(labels[i]))


def contest(folder: Path, seconds: float) -> Scores:
    """Let all take turns on the same points, and compare their meshes with these."""
    cloud = Cloud.of(clouds.solid(COUNT))
    cloud.save(folder, "solid")
    python = os.environ.get("IPFIT_BENCH_OPEN3D", sys.executable)

    def run(name: str) -> Any:  # noqa: ANN401 - a report
        asked = Asked("poisson", name, folder, python) if name in poisson.NAMES else Asked("meshes", name, folder)
        return alone(asked)

    scores = interleaved([*WAYS, *poisson.NAMES], run, seconds)
    for name, one in scores.items():
        if not one.failed:
            one.found.update(_read(folder / f"{name}.npz", cloud))
    return scores


def _read(file: Path, cloud: Cloud) -> dict[str, float]:
    with np.load(file) as parts:
        return closeness((parts["vertices"], parts["faces"]), cloud)


def shown(scores: Scores) -> str:
    """Return the table, and a word on Open3D if it is not there."""
    lines = [[name, *_cells(one)] for name, one in scores.items()]
    heads = ["way", "s", "CPU s", "peak MB", "D_dist", "D_smooth", "stray", "pieces", "triangles"]
    name = clouds.solid(COUNT).name
    missing = any(one.failed.startswith("ModuleNotFoundError") for one in scores.values())
    words = " Open3D was not installed here: its rows are empty." if missing else ""
    return f"{COUNT:,} points of {name} at most. {how_many(scores)}.{words}\n\n{table(heads, lines)}"


def _cells(one: Medians) -> list[str]:
    if one.failed:
        return [one.failed, *[""] * 7]
    found = one.found
    return [
        *(f"{one.seconds:.2f}", f"{one.cpu:.2f}", f"{one.above:.0f}"),
        *(f"{found['d_dist']:.4f}", f"{found['d_smooth']:.3f}", f"{found['stray']:.3f}"),
        *(f"{found['pieces']:.0f}", f"{found['triangles']:,}"),
    ]
