"""Time per point and memory for growing numbers of points, and for a set that is streamed from files."""

from functools import partial
from itertools import pairwise
from pathlib import Path
from time import perf_counter

import numpy as np

from contest import clouds
from contest.clouds import Cloud, Pieces
from contest.fitting import FEW, closeness, fitted
from contest.process import ContenderRef, run_alone
from contest.rounds import Scores, interleaved, rounds_as_text, seconds_of
from contest.target import Target, at_most
from contest.trial import Contender, Trial
from evidence.table import table

BASE = 30_000  # points; larger clouds are drawn from these again
SIZES = (10_000, 100_000, 1_000_000)
STREAMED = 10_000_000
MAPPED, CHUNKS = "memory-mapped", "in pieces"
JUDGED = 20_000  # points at which the fit is measured


def _held(count: int, folder: Path) -> Trial:
    cloud = Cloud.load(folder, str(count))
    few, seen = cloud.first(FEW), cloud.first(JUDGED)
    return Trial(lambda: fitted(few), lambda: fitted(cloud), lambda found: closeness(found.polynomial, seen))


def _mapped(folder: Path) -> Trial:
    cloud, few = Cloud.load(folder, str(STREAMED), mapped=True), _few(folder)
    return Trial(lambda: fitted(few), lambda: fitted(cloud), lambda found: closeness(found.polynomial, few))


def _few(folder: Path) -> Cloud:
    """Return a few points of the same surface without reading the streamed files, whose pages would count as memory."""
    return Cloud.load(folder, str(SIZES[0])).first(FEW)


def _pieces(folder: Path) -> Trial:
    few = _few(folder)
    pieces = Pieces(folder, str(STREAMED))
    return Trial(
        lambda: fitted(few),
        lambda: fitted(few, given={"points": iter(pieces), "normals": None}),
        lambda found: closeness(found.polynomial, few),
    )


CONTENDERS: dict[str, Contender] = {
    **{str(count): partial(_held, count) for count in SIZES},
    MAPPED: _mapped,
    CHUNKS: _pieces,
}


def contest(folder: Path, seconds: float) -> Scores:
    """Run the two streamed fits once each, then all sizes in rounds."""
    started, base = perf_counter(), Cloud.of(clouds.named(clouds.names()[0], BASE))
    for count in (*SIZES, STREAMED):
        clouds.write_resampled(base, count, folder, str(count))
    streamed = interleaved([MAPPED, CHUNKS], lambda name: run_alone(ContenderRef("scale", name, folder)), 0.0)
    left = started + seconds - perf_counter()
    scores = interleaved(
        [str(count) for count in SIZES], lambda name: run_alone(ContenderRef("scale", name, folder)), left
    )
    return {**scores, **streamed}


def targets(scores: Scores) -> list[Target]:
    """Return the targets: constant time per point, and peak memory."""
    per = np.array([seconds_of(scores, str(count)) / count for count in SIZES])  # the maximum is NaN if one of them is
    slopes = np.array(_slopes(scores))
    note = f" (of what each further point costs: {slopes.max() / slopes.min():.2f})"
    what = f"time per point from {SIZES[0]:,} to {SIZES[-1]:,} points, largest over smallest"
    largest = scores[str(SIZES[-1])]
    lines = [
        at_most(what, float(per.max() / per.min()), 1.2, note=note),
        at_most(f"peak above the input at {SIZES[-1]:,} points", largest.above, 200.0, " MB"),
    ]
    lines += [
        at_most(f"resident in all, {STREAMED:,} points {way}", scores[way].resident, 500.0, " MB")
        for way in (MAPPED, CHUNKS)
    ]
    return lines


def _slopes(scores: Scores) -> list[float]:
    """Return the seconds that each further point costs between one size and the next."""
    taken = [seconds_of(scores, str(count)) for count in SIZES]
    return [(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(zip(SIZES, taken, strict=True))]


def shown(scores: Scores) -> str:
    """Return the table."""
    sizes = {str(count): count for count in SIZES} | {MAPPED: STREAMED, CHUNKS: STREAMED}
    further = dict(zip([str(count) for count in SIZES[1:]], _slopes(scores), strict=True))
    lines = []
    for name, one in scores.items():
        label = "in memory" if name.isdecimal() else name
        if one.failed:
            lines.append([f"{sizes[name]:,}", label, one.failed, *[""] * 6])
            continue
        slope = f"{1e6 * further[name]:.2f}" if name in further else ""
        cells = [f"{one.seconds:.3f}", f"{1e6 * one.seconds / sizes[name]:.2f}", slope]
        cells += [f"{one.above:.0f}", f"{one.resident:.0f}", f"{one.found['d_dist']:.6f}"]
        lines.append([f"{sizes[name]:,}", label, *cells, f"{one.found['d_smooth']:.5f}"])
    heads = ["points", "held", "s", "µs per point", "µs per further point", "peak MB above", "resident MB in all"]
    once = f"{rounds_as_text({name: one for name, one in scores.items() if name.isdecimal()})}; streamed once each way."
    return f"{once}\n\n{table([*heads, 'D_dist', 'D_smooth'], lines)}"
