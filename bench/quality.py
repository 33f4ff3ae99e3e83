"""Make bench/QUALITY.md, how quiet fits are on real data: `IPFIT_BENCH_DATA=folder python bench/quality.py [NAME …]`.

With names only those sets are fitted, and their rows printed; the page is written when all are.

A fit is *good* when D_dist < 0.01, D_smooth > 0.95, stray < 0.001 and the zero set has one component, in the data's box
grown by 0.3 mean radii, on a grid of 240 lines (2D) or 88 (3D) along the longest axis.
"""

import os
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy is loaded: one thread, as in a worker

import ipcore  # noqa: E402 - see above
import sets  # noqa: E402
from evidence import plot  # noqa: E402
from evidence.table import table  # noqa: E402

HERE = Path(__file__).parent
MOST = 8000  # points; larger sets are sampled
LINEAR_CAP = {2: 18, 3: 12}
WAYS: dict[str, dict[str, Any]] = {
    "3L": {"geometric": False},
    "3L, ridge": {"geometric": False, "ridge": "full", "ridge_strength": 1e-3},
    "3L, selective ridge": {"geometric": False, "ridge": "selective", "collinear_tol": 1e-3, "ridge_strength": 1e-3},
    "default": {},
}
PICTURED = (
    *("mp7_heart", "mp7_bone", "mp7_apple", "mp7_bird", "nsfish_mid", "horse", "mp7_fish", "coast_madagascar"),
    *("bunny_npm", "spot", "duck_pybullet", "hand_od"),
)


@dataclass(frozen=True, eq=False)
class Scored:
    """A fit, the processor time it took, and what its zero set looks like."""

    result: ipcore.FitResult
    seconds: float
    stray: float
    components: int

    @property
    def good(self) -> bool:
        """Return whether it is close, smooth, quiet and whole."""
        found = self.result.diagnostics
        return found.d_dist < 0.01 and found.d_smooth > 0.95 and self.stray < 0.001 and self.components == 1

    def cells(self) -> list[str]:
        """Return degree, D_dist, D_smooth, stray, components, seconds, verdict."""
        found, met = self.result.diagnostics, self.result.stop_reason is ipcore.StopReason.CRITERION_MET
        return [
            f"{self.result.degree}{'' if met else ' (cap)'}",
            f"{found.d_dist:.4f}",
            f"{found.d_smooth:.3f}",
            f"{self.stray:.4f}",
            str(self.components),
            f"{self.seconds:.2f}",
            "good" if self.good else "",
        ]


def usable(given: sets.PointSet) -> sets.PointSet:
    """Return the set, without its normals if some have no length."""
    if given.normals is not None and not given.normals.any(axis=1).all():
        return replace(given, normals=None)
    return given


def fitted(given: sets.PointSet, way: str) -> Scored:
    """Fit a set one way."""
    options = dict(WAYS[way])
    if way != "default":
        options["max_degree"] = LINEAR_CAP[given.dimension]
    started = process_time()
    result = ipcore.fit(given.points, given.normals, ipcore.FitOptions.of(measure_zero_set=False, **options))
    seconds = process_time() - started
    lines = {2: 240, 3: 88}[given.dimension]
    whole = ipcore.zero_set(result.polynomial, resolution=lines, data=given.points, restrict=False, cap=False)
    return Scored(result, seconds, 1.0 if whole.stray is None else whole.stray, whole.components)


def rows(entries: list[dict[str, object]], scored: dict[str, dict[str, Scored]]) -> Iterator[list[str]]:
    """Return a table row per set and way."""
    for entry in entries:
        for way, one in scored[str(entry["name"])].items():
            yield [str(entry["name"]) if way == "3L" else "", way, *one.cells()]


def summary(entries: list[dict[str, object]], scored: dict[str, dict[str, Scored]]) -> list[str]:
    """Return one line of counts and medians per way."""
    for_closed = [scored[str(entry["name"])] for entry in entries if entry["closed"]]
    lines = []
    for way in WAYS:
        good = sum(one[way].good for one in for_closed)
        times = [
            median([one[way].seconds for one in for_closed if one[way].result.polynomial.dimension == d] or [0.0])
            for d in (2, 3)
        ]
        where = f"{good} of {len(for_closed)} closed shapes good"
        lines.append(f"- {way}: {where}; median {times[0]:.2f} s (2D), {times[1]:.1f} s (3D)")

    both = [one for one in for_closed if one["3L"].result.stop_reason is ipcore.StopReason.CRITERION_MET]
    if both:
        quotients = [one["default"].result.degree / one["3L"].result.degree for one in both]
        lines.append(
            f"- degree over that of plain 3L, where that meets the rule ({len(both)} shapes): "
            f"median {median(quotients):.2f}, largest {max(quotients):.2f}"
        )
    return lines


def pictures(scored: dict[str, dict[str, Scored]], given: dict[str, sets.PointSet]) -> None:
    """Draw the dozen, before and after."""
    figure, axes = plot.new(6, 4, 1.9)
    for k, name in enumerate(PICTURED):
        for j, way in enumerate(("3L", "default")):
            axis, one = axes[2 * k + j], scored[name][way]
            draw = plot.outline if given[name].dimension == 2 else plot.surface
            draw(axis, given[name], one.result.polynomial)
            axis.set_title(f"{name}: {way}, degree {one.result.degree}")
    (HERE / "quality").mkdir(exist_ok=True)
    figure.savefig(HERE / "quality" / "before-and-after.png", dpi=110)


HEADS = ("set", "fit", "degree", "D_dist", "D_smooth", "stray", "components", "seconds", "")


def page(entries: list[dict[str, object]], scored: dict[str, dict[str, Scored]]) -> Iterator[str]:
    """Return the page, part by part."""
    yield "# How quiet the fits are"
    yield (__doc__ or "").split("\n\n", 2)[2].strip()
    yield (
        f"Made by `python bench/quality.py` with Python {platform.python_version()} on {platform.machine()}, with one "
        f"thread; sets of more than {MOST} points are sampled. Seconds are the processor's. "
        f"The linear fits end at degree {LINEAR_CAP[2]} (2D) and {LINEAR_CAP[3]} (3D). Sets without normals get "
        "estimated ones."
    )
    yield "![Before and after](quality/before-and-after.png)"
    for title, half in (("Even places of the index", entries[::2]), ("Odd places of the index", entries[1::2])):
        yield f"## {title}"
        yield "\n".join(summary(half, scored))
        yield table(HEADS, rows(half, scored))
    yield (HERE / "quality" / "words.md").read_text(encoding="utf-8").strip()


def main() -> None:
    """Fit, print, and write the page if every set was fitted."""
    entries = [entry for entry in sets.index() if not sys.argv[1:] or entry["name"] in sys.argv[1:]]
    scored: dict[str, dict[str, Scored]] = {}
    given: dict[str, sets.PointSet] = {}
    for entry in entries:
        name = str(entry["name"])
        given[name] = usable(sets.load(name).sample(MOST))
        scored[name] = {way: fitted(given[name], way) for way in WAYS}
        for row in rows([entry], scored):
            print(" | ".join(row), flush=True)
    if not sys.argv[1:]:
        pictures(scored, given)
        (HERE / "QUALITY.md").write_text("\n\n".join(page(entries, scored)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
