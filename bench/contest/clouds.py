"""The oriented points of all contenders: sets of the folder in IPFIT_BENCH_DATA, or bent shapes of `ipcore.shapes`.

The shapes are bent because points of an algebraic surface make collinear columns, which real points never do.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import held_back
import sets
from ipcore import shapes
from sets import FloatArray, PointSet

PIECE = 100_000  # points made or read at once: 5 MB
SPREAD = 0.5  # how far a point that is drawn again moves along the surface, in distances between neighbours
SOLID = ("bunny_zipper", "spot", "armadillo_od", "duck_pybullet")
FLAT = ("horse", "mp7_bird")
MADE = {
    "bent genus-2 quartic": shapes.genus_two,
    "bent torus": shapes.torus,
    "bent superellipse": shapes.superellipse,
    "bent cubic": shapes.cubic,
}
BEND, WAVES = 0.1, 3.0  # x → x + BEND sin(WAVES y), and so on for the other axes; BEND · WAVES < 1, so nothing folds


def from_folder() -> bool:
    """Return whether a folder of sets is named."""
    return "IPFIT_BENCH_DATA" in os.environ


def names() -> tuple[str, ...]:
    """Return the names of the sets that are compared degree by degree, surfaces first."""
    return (*SOLID, *FLAT) if from_folder() else tuple(MADE)


def named(name: str, count: int) -> PointSet:
    """Return one of these sets, sampled to at most `count` points."""
    if from_folder():
        return sets.load(name).sample(count)
    return bent(name, count)


def bent(name: str, count: int) -> PointSet:
    """Return a shape whose points are moved by waves, and its normals with them, by the inverse of the Jacobian."""
    points, normals = MADE[name]().sample(count)
    d = points.shape[1]
    before = np.roll(np.arange(d), 1)
    wave = WAVES * points[:, before]
    J = np.tile(np.eye(d), (len(points), 1, 1))
    J[:, np.arange(d), before] += BEND * WAVES * np.cos(wave)
    n = np.linalg.solve(np.swapaxes(J, 1, 2), normals[:, :, None])[:, :, 0]
    return PointSet(name, points + BEND * np.sin(wave), n / np.linalg.norm(n, axis=1)[:, None], closed=True)


def outlines(most: int) -> list[PointSet]:
    """Return outlines, evenly thinned to at most so many points: all of the folder, or letters."""
    if from_folder():
        there = [sets.load(str(entry["name"])) for entry in sets.index() if entry["dim"] == 2]
    else:
        there = [one for one in held_back.shapes() if one.dimension == 2]
    return [_thinned(one, most) for one in there]


def _thinned(one: PointSet, most: int) -> PointSet:
    """Return an outline with at most so many of its points, evenly spaced in their order."""
    keep = np.unique(np.linspace(0, len(one.points) - 1, min(most, len(one.points))).round().astype(np.intp))
    normals = None if one.normals is None else one.normals[keep]
    return PointSet(one.name, one.points[keep], normals, one.closed)


def solid(count: int) -> PointSet:
    """Return the closed surface from which the contest of meshes starts."""
    return named("spot" if from_folder() else "bent genus-2 quartic", count)


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points and normals (N, d) each."""

    points: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, given: PointSet) -> "Cloud":
        """Return the cloud of a set; it must have normals."""
        if given.normals is None:
            raise ValueError(f"{given.name} has no normals")
        return cls(given.points, given.normals)

    def save(self, folder: Path, name: str) -> None:
        """Write points and normals to two npy files."""
        np.save(folder / f"{name}-points.npy", self.points)
        np.save(folder / f"{name}-normals.npy", self.normals)

    @classmethod
    def load(cls, folder: Path, name: str, *, mapped: bool = False) -> "Cloud":
        """Read the two files, or map them into memory."""
        files = (folder / f"{name}-points.npy", folder / f"{name}-normals.npy")
        return cls(*(np.load(file, mmap_mode="r" if mapped else None) for file in files))

    def first(self, count: int) -> "Cloud":
        """Return so many points, spread evenly over the order of the cloud."""
        step = max(1, len(self.points) // count)
        return Cloud(self.points[::step][:count].copy(), self.normals[::step][:count].copy())


def write_resampled(base: Cloud, count: int, folder: Path, name: str) -> None:
    """Write a cloud of any size, piece by piece: points of `base`, drawn again and moved a little along the surface."""
    shape = (count, base.points.shape[1])
    files = [
        np.lib.format.open_memmap(folder / f"{name}-{kind}.npy", mode="w+", dtype=np.float64, shape=shape)
        for kind in ("points", "normals")
    ]
    for part, piece in _pieces(base, count):
        files[0][part], files[1][part] = piece.points, piece.normals


def _pieces(base: Cloud, count: int) -> Iterator[tuple[slice, Cloud]]:
    generator = np.random.default_rng(0)
    spacing = float(np.median(np.asarray(cKDTree(base.points).query(base.points, k=2)[0])[:, 1]))
    for start in range(0, count, PIECE):
        part = slice(start, min(start + PIECE, count))
        at = generator.integers(len(base.points), size=part.stop - start)
        p, n = base.points[at], base.normals[at]
        step = generator.normal(scale=SPREAD * spacing, size=p.shape)
        yield part, Cloud(p + step - np.einsum("nk,nk->n", step, n)[:, None] * n, n)


class Pieces:
    """The pieces of a cloud in files. Each iteration reads all of them again, one at a time."""

    def __init__(self, folder: Path, name: str) -> None:
        """Take the folder and the name of the cloud."""
        self._folder, self._name = folder, name

    def __iter__(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield points and normals (N, d) of each piece, in memory."""
        mapped = Cloud.load(self._folder, self._name, mapped=True)
        shape, skipped = mapped.points.shape, mapped.points.offset  # type: ignore[attr-defined] # a memmap's
        with (
            (self._folder / f"{self._name}-points.npy").open("rb") as points,
            (self._folder / f"{self._name}-normals.npy").open("rb") as normals,
        ):
            for file in (points, normals):
                file.seek(skipped)
            for start in range(0, shape[0], PIECE):
                numbers = min(PIECE, shape[0] - start) * shape[1]
                yield (
                    np.fromfile(points, count=numbers).reshape(-1, shape[1]),
                    np.fromfile(normals, count=numbers).reshape(-1, shape[1]),
                )
