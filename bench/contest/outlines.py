"""Outlines of at most 500 points, all in one process: the linear fit and the default one."""

from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import ipcore
from contest import clouds
from contest.process import ContenderRef, run_alone
from contest.rounds import Medians, Scores, interleaved, rounds_as_text
from contest.target import Target, at_most
from contest.trial import Contender, Trial
from evidence.table import table
from sets import PointSet

COUNT = 500
PLAIN, BARE, DEFAULT = "plain", "plain, zero set not measured", "default"
FITS: dict[str, dict[str, Any]] = {
    PLAIN: {"geometric": False},
    BARE: {"geometric": False, "measure_zero_set": False},
    DEFAULT: {},
}
GOALS = {PLAIN: 10.0, DEFAULT: 80.0}  # ms


def _fit(given: PointSet, options: ipcore.FitOptions) -> tuple[float, ipcore.FitResult]:
    started = perf_counter()
    result = ipcore.fit(given.points, given.normals, options)
    return 1e3 * (perf_counter() - started), result


def _judged(fits: list[tuple[float, ipcore.FitResult]]) -> dict[str, Any]:
    """Return the milliseconds of every outline, and the medians of degree, D_dist and D_smooth."""
    results = [result for _, result in fits]
    return {
        "ms": [taken for taken, _ in fits],
        "degree": median(one.degree for one in results),
        "d_dist": median(one.diagnostics.d_dist for one in results),
        "d_smooth": median(one.diagnostics.d_smooth for one in results),
    }


def _ready(way: str, folder: Path) -> Trial:  # noqa: ARG001 - small sets are read where they are
    options, given = ipcore.FitOptions.of(**FITS[way]), clouds.outlines(COUNT)

    def work() -> list[tuple[float, ipcore.FitResult]]:
        return [_fit(one, options) for one in given]

    return Trial(work, work, _judged)


CONTENDERS: dict[str, Contender] = {way: partial(_ready, way) for way in FITS}


def contest(folder: Path, seconds: float) -> Scores:
    """Run the fits in turn on all outlines."""
    return interleaved(list(FITS), lambda way: run_alone(ContenderRef("outlines", way, folder)), seconds)


def targets(scores: Scores) -> list[Target]:
    """Return the targets of the median outline."""
    bare = _middle(scores, BARE)
    notes = {PLAIN: f" ({bare:.3g} ms when the zero set is not measured)"}
    what = f"median outline of at most {COUNT} points, {{}} fit"
    return [
        at_most(what.format(way), _middle(scores, way), limit, " ms", notes.get(way, ""))
        for way, limit in GOALS.items()
    ]


def _middle(scores: Scores, way: str) -> float:
    return median(_each(scores[way]) or [float("nan")])


def _each(one: Medians) -> list[float]:
    """Return the milliseconds of every outline, medians of the rounds; empty if a run failed."""
    return [] if one.failed else [median(runs) for runs in zip(*(run.found["ms"] for run in one.reports), strict=True)]


def shown(scores: Scores) -> str:
    """Return the table."""
    lines = []
    for way, one in scores.items():
        if one.failed:
            lines.append([way, one.failed, *[""] * 6])
            continue
        found = one.found
        times = [f"{f(_each(one)):.1f}" for f in (median, min, max)]
        lines.append([way, *times, f"{found['degree']:g}", f"{found['d_dist']:.4f}", f"{found['d_smooth']:.3f}"])
    heads = ["fit", "ms, median", "least", "most", "degree", "D_dist", "D_smooth"]
    count = len(clouds.outlines(COUNT))
    return f"{count} outlines of at most {COUNT} points. {rounds_as_text(scores)}.\n\n{table(heads, lines)}"
