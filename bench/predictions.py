"""Write bench/PREDICTIONS.md: the time that `ipcore.plan` predicts for fits, beside the time that they take.

Every fit runs in a process of its own, on one thread as in a worker of the service, and its CPU time is measured, so
that other work on the machine hardly counts. `python bench/predictions.py --json` prints the measurements as JSON.
"""

import os

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
os.environ.update(dict.fromkeys(THREADS, "1"))  # before numpy is loaded

import argparse
import json
import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from time import process_time
from typing import Any

import numpy as np

import ipcore
from evidence.table import table

TARGET = Path(__file__).parent / "PREDICTIONS.md"
NOISE = 0.03  # standard deviation, in mean radii: three times t1, so that no degree is close enough
HEADS = ["group", "case", "predicted, s", "measured, s", "predicted / measured", "degree", "constants fitted to it"]
WORDS = """\
# Predicted and measured times of fits

`python bench/predictions.py` (`make bench-predictions`) writes this file. Each fit ran in a process of its own on one
thread; the times are CPU seconds. The points lie on a bent circle or sphere, with noise of {noise:g} of its radius
along the normals. The constants of `ipcore.planning` were fitted to the cases marked *yes*. *degree* is the last degree
that was tried.

`ipcore.plan` predicts the time of a fit that goes on to its last degree. Predicted over measured time is

- {low:.2f} … {high:.2f} for the {count} fits that went on to their last degree and that no constant was fitted to;
- {early_low:.1f} … {early_high:.1f} for the {early} fits that stopped earlier. Their points have no noise.

"""


@dataclass(frozen=True)
class Case:
    """A fit to predict and to measure.

    Attributes
    ----------
    group
        The part of the prediction that it is about.
    dimension, points
        d and N.
    options
        Options by name.
    normals
        `given`, `estimated`, or `outline` for 2D points in order along their curve.
    noise
        Standard deviation of the points along their normals, in mean radii.
    calibrates
        Whether the constants of `ipcore.planning` were fitted to it.

    """

    group: str
    dimension: int
    points: int
    options: dict[str, Any] = field(default_factory=dict)
    normals: str = "given"
    noise: float = NOISE
    calibrates: bool = False

    @property
    def title(self) -> str:
        """Return dimension, number of points and options in words."""
        chosen = ", ".join(f"{name}={value}" for name, value in self.options.items())
        source = "" if self.normals == "given" else f", normals {self.normals}"
        return f"{self.dimension}D, {self.points:,} points{source}: {chosen}"


@dataclass(frozen=True)
class Measurement:
    """CPU seconds of a fit, bytes by which its process grew, and the last degree that it tried."""

    seconds: float
    bytes: int
    degree: int


def _grouped(
    group: str, cases: list[tuple[int, int, dict[str, Any]]], normals: str = "given", noise: float = NOISE
) -> Iterator[Case]:
    """Yield the cases of a group; every other one calibrates."""
    for i, (dimension, points, options) in enumerate(cases):
        yield Case(group, dimension, points, options, normals, noise, calibrates=i % 2 == 0 and noise > 0.0)


def _degrees(*cases: tuple[int, int, int], **options: Any) -> list[tuple[int, int, dict[str, Any]]]:  # noqa: ANN401 - any
    """Return cases (dimension, points, max_degree) that share the other options."""
    return [(dimension, points, {"max_degree": degree, **options}) for dimension, points, degree in cases]


GEOMETRIC = [
    *_degrees(
        *[(3, 100, 4), (3, 1000, 6), (3, 1000, 9), (3, 3000, 11), (3, 10_000, 6), (3, 10_000, 8), (3, 100_000, 7)],
        *[(3, 100_000, 5), (3, 1_000_000, 4), (3, 400_000, 4), (2, 100, 8), (2, 1000, 10), (2, 10_000, 14)],
        *[(2, 100_000, 12), (2, 1000, 20), (2, 1_000_000, 6)],
    ),
    *_degrees((2, 5000, 24), (2, 3000, 16), (2, 400_000, 8), (3, 20_000, 5), criterion="none"),
    *_degrees((2, 1000, 6), (2, 3000, 18), (3, 3000, 7), (3, 3000, 8), t1=0.003),
]
LINEAR = _degrees(
    *[(3, 1000, 8), (3, 5000, 6), (3, 20_000, 10), (3, 100_000, 7), (3, 400_000, 5), (3, 20_000, 14), (3, 5000, 15)],
    *[(3, 1_000_000, 4), (2, 100_000, 12), (2, 1000, 10), (2, 1_000_000, 8), (2, 10_000, 14), (2, 100_000, 18)],
    *[(2, 20_000, 20), (3, 50_000, 16), (3, 200_000, 10)],
    geometric=False,
)
HELD = [
    *_degrees(
        (3, 5000, 9), (3, 20_000, 7), (2, 5000, 16), (2, 50_000, 10), (3, 20_000, 11), (3, 5000, 13), factor="block"
    ),
    *_degrees((3, 5000, 7), (2, 10_000, 12), constraints="min-max"),
    *_degrees((3, 5000, 7), (2, 10_000, 10), constraints="taubin"),
    *_degrees((2, 5000, 10), (3, 3000, 6), criterion="loo"),
    *_degrees((3, 20_000, 8), (2, 50_000, 14), (3, 20_000, 13), (3, 5000, 15), factor="tsqr"),
    *_degrees((3, 20_000, 8), (2, 50_000, 14), (3, 10_000, 12), (2, 20_000, 20), constraints="3l+gradient"),
    *_degrees((3, 50_000, 8), (2, 50_000, 14), constraints="5l"),
]
PAPER = _degrees(
    (3, 500, 5),
    (3, 3000, 6),
    (2, 500, 10),
    (2, 3000, 12),
    (3, 1000, 8),
    (2, 10_000, 9),
    (3, 2000, 10),
    (2, 2000, 20),
    preset="paper",
)
ROBUST = _degrees(
    (3, 1000, 6), (3, 20_000, 6), (3, 200_000, 4), (2, 1000, 12), (2, 20_000, 10), (2, 200_000, 8), robust=True
)
SIGNS = _degrees((3, 10_000, 6), (3, 2000, 8), (2, 2000, 16), (2, 10_000, 12), signs=True, geometric=False)
ESTIMATED = [
    (dimension, points, {"max_degree": 2, "geometric": False, "neighbours": neighbours})
    for dimension, points, neighbours in [
        *[(3, 1000, 12), (3, 10_000, 12), (3, 10_000, 100), (3, 30_000, 50), (3, 100_000, 12), (3, 300_000, 12)],
        *[(3, 100_000, 100), (2, 1000, 12), (2, 10_000, 12), (2, 10_000, 100), (2, 100_000, 30), (2, 100_000, 12)],
    ]
]
OUTLINES = [(2, points, {"max_degree": 2, "geometric": False}) for points in (1000, 10_000, 100_000)]
CLEAN = [(2, 1000, {}), (2, 100_000, {}), (3, 1000, {}), (3, 20_000, {}), (3, 20_000, {"geometric": False})]
CASES = (
    *_grouped("geometric", GEOMETRIC),
    *_grouped("linear", LINEAR),
    *_grouped("other factors and families", HELD),
    *_grouped("paper", PAPER),
    *_grouped("robust", ROBUST),
    *_grouped("signs only", SIGNS),
    *_grouped("estimated normals", ESTIMATED, "estimated"),
    *_grouped("outlines", OUTLINES, "outline", noise=0.0),
    *_grouped("clean, stops early", CLEAN, noise=0.0),
)


def shape(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Return points (N, d) with noise on a closed curve or surface that no polynomial describes, and its normals."""
    d, random = case.dimension, np.random.default_rng(case.points)
    if case.normals == "outline":
        angle = np.linspace(0.0, 2.0 * np.pi, case.points, endpoint=False)
        u = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    else:
        u = random.normal(size=(case.points, d))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
    r, slope = 1.0 + 0.2 * np.sin(3.0 * u[:, :1]), 0.6 * np.cos(3.0 * u[:, :1])  # r(u) and dr/du₁
    axis = np.eye(1, d)
    normals = u - slope / r * (axis - u * u[:, :1])  # ∇(|x| − r(x/|x|))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return r * u + case.noise * random.normal(size=(case.points, 1)) * normals, normals


def measure(case: Case) -> Measurement:
    """Fit in this process, and return what it took."""
    points, normals = shape(case)
    options = ipcore.FitOptions.of(**case.options)
    before, started = getrusage(RUSAGE_SELF).ru_maxrss, process_time()
    result = ipcore.fit(points, normals if case.normals == "given" else None, options, threads=1)
    seconds = process_time() - started
    return Measurement(seconds, 1024 * (getrusage(RUSAGE_SELF).ru_maxrss - before), result.steps[-1].degree)


def predicted(case: Case) -> ipcore.Plan:
    """Return the plan of a case."""
    options = ipcore.FitOptions.of(**case.options)
    return ipcore.plan(case.dimension, case.points, options, normals=case.normals == "given")


def measured(cases: list[Case]) -> Iterator[tuple[Case, Measurement]]:
    """Yield every case with its measurement, each from a new process."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["ipcore"])
    with ProcessPoolExecutor(1, context, max_tasks_per_child=1) as child:
        for case in cases:
            yield case, child.submit(measure, case).result()


def row(case: Case, found: Measurement) -> list[str]:
    """Return a case as a row of the table."""
    seconds, used = predicted(case).seconds, "yes" if case.calibrates else "no"
    ratio = f"{seconds / found.seconds:.2f}"
    return [case.group, case.title, f"{seconds:.2f}", f"{found.seconds:.2f}", ratio, str(found.degree), used]


def document(found: list[tuple[Case, Measurement]]) -> str:
    """Return all cases as a Markdown document."""
    plans = [predicted(case) for case, _ in found]
    last = [plan.max_degree == one.degree for plan, (_, one) in zip(plans, found, strict=True)]
    ratios = [plan.seconds / one.seconds for plan, (_, one) in zip(plans, found, strict=True)]
    tested = [r for r, whole, (case, _) in zip(ratios, last, found, strict=True) if whole and not case.calibrates]
    early = [r for r, whole in zip(ratios, last, strict=True) if not whole]
    words = WORDS.format(
        noise=NOISE,
        count=len(tested),
        low=min(tested),
        high=max(tested),
        early=len(early),
        early_low=min(early),
        early_high=max(early),
    )
    return f"{words}{table(HEADS, [row(*one) for one in found])}\n"


def main() -> None:
    """Measure the cases of one group or of all, and write the document if it is all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print the measurements as JSON, one a line")
    parser.add_argument("--group", help="run this group only")
    given = parser.parse_args()
    done = []
    for case, found in measured([case for case in CASES if given.group in {None, case.group}]):
        done.append((case, found))
        print(json.dumps([asdict(case), asdict(found)]) if given.json else " | ".join(row(case, found)), flush=True)
    if given.group is None:
        TARGET.write_text(document(done), encoding="utf-8")


if __name__ == "__main__":
    main()
