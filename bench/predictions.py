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
from dataclasses import asdict, dataclass
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from time import process_time

import numpy as np

import ipcore
from evidence.table import table
from predicted import CASES, NOISE, Case

TARGET = Path(__file__).parent / "PREDICTIONS.md"
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
class Measurement:
    """CPU seconds of a fit, bytes by which its process grew, and the last degree that it tried."""

    seconds: float
    bytes: int
    degree: int


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
