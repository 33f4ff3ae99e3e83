"""Poisson reconstruction by Open3D. The module needs only Open3D and numpy, so another Python can run it."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from contest.trial import Contender, Trial

DEPTHS = (6, 8)  # grids of 64³ and 256³


def mesh(points: Any, normals: Any, depth: int) -> Any:  # noqa: ANN401 - Open3D has no annotations
    """Return a triangle mesh of points with normals (N, 3)."""
    import open3d  # noqa: PLC0415 - where there is none, only this contender fails

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.normals = open3d.utility.Vector3dVector(normals)
    return open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth)[0]


def _ready(name: str, depth: int, folder: Path) -> Trial:
    points, normals = np.load(folder / "solid-points.npy"), np.load(folder / "solid-normals.npy")

    def judged(found: Any) -> dict[str, Any]:  # noqa: ANN401 - as above
        np.savez(folder / f"{name}.npz", vertices=np.asarray(found.vertices), faces=np.asarray(found.triangles))
        return {}

    return Trial(lambda: mesh(points[::10], normals[::10], 4), lambda: mesh(points, normals, depth), judged)


NAMES = {f"Open3D Poisson, depth {depth}": depth for depth in DEPTHS}
CONTENDERS: dict[str, Contender] = {name: partial(_ready, name, depth) for name, depth in NAMES.items()}
