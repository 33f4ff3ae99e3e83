"""The point sets that the benchmarks run on: a folder with `index.json`, `2d/NAME.npz` and `3d/NAME.npz`.

Its path stands in IPFIT_BENCH_DATA. Each file holds `points` (N, d) and, mostly, unit outward `normals` (N, d); the
index names each set with its dimension `dim` and whether it is `closed`. The sets do not come with this project.
"""

import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointSet:
    """A named set: points (N, d), and normals (N, d) if it has them."""

    name: str
    points: FloatArray
    normals: FloatArray | None
    closed: bool

    @property
    def dimension(self) -> int:
        """Return d."""
        return int(self.points.shape[1])

    @property
    def scale(self) -> float:
        """Return the mean radius, in the set's unit."""
        return float(np.linalg.norm(self.points - self.points.mean(axis=0), axis=1).mean())

    def sample(self, count: int) -> "PointSet":
        """Return the set, or `count` points of it drawn with a fixed seed, in their order."""
        if len(self.points) <= count:
            return self
        keep = np.sort(np.random.default_rng(0).choice(len(self.points), count, replace=False))
        normals = None if self.normals is None else self.normals[keep]
        return PointSet(self.name, self.points[keep], normals, self.closed)

    def noisy(self, sigma: float) -> "PointSet":
        """Return the set with every coordinate moved by Gaussian noise of sigma mean radii, with a fixed seed."""
        noise = np.random.default_rng(1).normal(scale=sigma * self.scale, size=self.points.shape)
        return PointSet(self.name, self.points + noise, self.normals, self.closed)


def folder() -> Path:
    """Return the folder of the sets, or end the program with a message that says how to name it."""
    given = os.environ.get("IPFIT_BENCH_DATA")
    if not given or not (Path(given) / "index.json").is_file():
        sys.exit("IPFIT_BENCH_DATA must name a folder with index.json, 2d/ and 3d/; see bench/sets.py")
    return Path(given)


def index() -> list[dict[str, object]]:
    """Return the index, in its order."""
    entries: list[dict[str, object]] = json.loads((folder() / "index.json").read_text(encoding="utf-8"))
    return entries


def load(name: str) -> PointSet:
    """Read one set by its name."""
    entry = next(entry for entry in index() if entry["name"] == name)
    with np.load(folder() / f"{entry['dim']}d" / f"{name}.npz") as file:
        points = file["points"].astype(float)
        normals = file["normals"].astype(float) if "normals" in file else None
    return PointSet(name, points, normals, bool(entry["closed"]))
