"""Time zero sets and estimated normals: `python bench/zero_sets.py [FOLDER]`.

With a folder that holds a checkout of another version, its times stand beside this one's. Versions and
thread counts run in turn, each in a process of its own with BLAS on one thread, so that other work on the machine slows
all of them alike. The table has medians of the rounds. CPU seconds depend less on that other work.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

import ipcore
from ipcore.polynomial import graded

HERE = Path(__file__).resolve().parent.parent
ROUNDS = 3


def bumpy(dimension: int) -> ipcore.ImplicitPolynomial:
    """Return a sphere or circle of degree 12 with random bumps, in Chebyshev products on a cube of ±1.5."""
    half, powers = 1.5, graded.exponents(dimension, 12)
    a = 0.3 * np.random.default_rng(0).normal(size=len(powers)) / (1 + powers.sum(axis=1))
    a[0] += dimension * half**2 / 2 - 1.0
    a[graded.column(2 * np.eye(dimension, dtype=np.intp))] += half**2 / 2  # (half t)² = half²/2 (T₂(t) + 1)
    box = np.array([[-half] * dimension, [half] * dimension])
    return ipcore.ImplicitPolynomial(12, a, ipcore.Frame(np.zeros(dimension), 1.0), box, ipcore.Basis.CHEBYSHEV)


def zero_set(dimension: int, resolution: int) -> Callable[[], str]:
    """Return a function that extracts a zero set and measures it against data; it returns the findings as text."""
    p = bumpy(dimension)
    data = ipcore.zero_set(p, resolution={2: 400, 3: 60}[dimension], cap=False).vertices

    def work() -> str:
        found = ipcore.zero_set(p, resolution=resolution, data=data)
        off = np.abs(p.distance(found.vertices[::100])).max()
        return f"{len(found.vertices)} vertices, {len(found.cells)} cells, off by {off:.0e}"

    return work


def normals(count: int) -> Callable[[], str]:
    """Return a function that estimates normals of random points on a torus; it returns the share pointing outward."""
    u, v = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (2, count))
    true = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    points = np.column_stack([np.cos(u), np.sin(u), 0.0 * u]) + 0.4 * true
    return lambda: f"{np.mean((ipcore.estimate_normals(points) * true).sum(axis=1) > 0.0):.2%} outward"


MEASUREMENTS: dict[str, Callable[[], Callable[[], str]]] = {
    "surface, 96³": lambda: zero_set(3, 96),
    "surface, 256³": lambda: zero_set(3, 256),
    "surface, 512³": lambda: zero_set(3, 512),
    "curve, 256²": lambda: zero_set(2, 256),
    "curve, 2048²": lambda: zero_set(2, 2048),
    "normals, 10,000 points": lambda: normals(10_000),
    "normals, 100,000 points": lambda: normals(100_000),
    "normals, 1,000,000 points": lambda: normals(1_000_000),
}


def measure(name: str) -> None:
    """Run one measurement in this process and print wall seconds, CPU seconds and the findings."""
    work = MEASUREMENTS[name]()
    wall, cpu = perf_counter(), process_time()
    findings = work()
    print(perf_counter() - wall, process_time() - cpu, findings)


def child(folder: Path, threads: int, name: str) -> tuple[float, float, str]:
    """Run one measurement in a child process with the version in a folder; return seconds, CPU seconds and findings."""
    limits = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": str(threads), "PYTHONPATH": str(folder)}
    command = [sys.executable, __file__, "--measure", name]
    answer = subprocess.run(command, env=os.environ | limits, check=True, stdout=subprocess.PIPE, text=True)  # noqa: S603 - ourselves
    wall, cpu, findings = answer.stdout.strip().split(" ", 2)
    return float(wall), float(cpu), findings


def main(before: Path | None) -> None:
    """Print the table."""
    cores = len(os.sched_getaffinity(0))
    versions = {"one thread": (HERE, 1), f"{cores} threads": (HERE, cores)}
    if before is not None:
        versions = {"before": (before, cores), **versions}
    print("| | " + " | ".join(f"{name}: s (CPU s)" for name in versions) + " | ratio | found |")
    print("| --- |" + " --- |" * (len(versions) + 2))
    for name in MEASUREMENTS:
        taken = [[child(folder, threads, name) for folder, threads in versions.values()] for _ in range(ROUNDS)]
        times = [(median(r[k][0] for r in taken), median(r[k][1] for r in taken)) for k in range(len(versions))]
        cells = [f"{wall:.3f} ({cpu:.3f})" for wall, cpu in times]
        ratio = f"{times[0][0] / times[-1][0]:.1f} ({times[0][1] / times[-1][1]:.1f})"
        print("| " + " | ".join([name, *cells, ratio, taken[0][-1][2]]) + " |", flush=True)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--measure", name]:
            measure(name)
        case [folder]:
            main(Path(folder).resolve())
        case _:
            main(None)
