"""Write bench/QUALITY.md, how good fits are: `IPFIT_BENCH_DATA=folder python bench/quality.py [--held-back | NAME …]`.

With names only those sets are fitted, and their rows printed; the page is written when all are. With --held-back only
the shapes of bench/held_back.py are, which need no folder, and their section and the words below it are written anew.

A fit is *good* when D_dist < 0.01, D_smooth > 0.95, stray < 0.001 and the zero set has one component, in the data's box
grown by 0.3 mean radii, on a grid of 240 lines (2D) or 88 (3D) along the longest axis. *Stray* is what lies beyond the
support radius of the points, also in the gaps of a sparse sample. The components are the pieces on that grid. *Proof*
says what is proved of the delivered coefficients: the number of components and the Euler characteristic; or only that
all zeros are near the points; or nothing. Its time is that of the processor, too.
"""

import os
import platform
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy is loaded: one thread, as in a worker

import numpy as np
from scipy.spatial import cKDTree

import held_back
import ipcore
import sets
from evidence import plot
from evidence.table import table
from ipcore.proof.prover import Proof, prove

HERE = Path(__file__).parent
MAX_POINTS = 8000  # larger sets are sampled
LINEAR_CAP = {2: 18, 3: 12}
FITS: dict[str, dict[str, Any]] = {
    "3L": {"geometric": False},
    "3L, ridge": {"geometric": False, "ridge": "full", "ridge_strength": 1e-3},
    "3L, selective ridge": {"geometric": False, "ridge": "selective", "collinear_tol": 1e-3, "ridge_strength": 1e-3},
    "default": {},
}
HELD_BACK_FITS = ("3L", "default")
PICTURED = (
    *("mp7_heart", "mp7_bone", "mp7_apple", "mp7_bird", "nsfish_mid", "horse", "mp7_fish", "coast_madagascar"),
    *("bunny_npm", "spot", "duck_pybullet", "hand_od"),
)

HEADS = ("set", "fit", "degree", "D_dist", "D_smooth", "stray", "components", "seconds", "", "proof", "its seconds")
HELD_BACK, CONCLUSIONS = "## Held back", HERE / "quality" / "conclusions.md"


@dataclass(frozen=True, eq=False)
class Scored:
    """A fit, its processor time in seconds, the stray share and number of components of its zero set, and a proof."""

    result: ipcore.FitResult
    seconds: float
    stray: float
    components: int
    proof: Proof
    proof_seconds: float

    @property
    def good(self) -> bool:
        """Return whether the fit is close and smooth, and its zero set without stray parts and in one piece."""
        found = self.result.diagnostics
        return found.d_dist < 0.01 and found.d_smooth > 0.95 and self.stray < 0.001 and self.components == 1

    def cells(self) -> list[str]:
        """Return degree, D_dist, D_smooth, stray, components, seconds, verdict, what is proved, and its seconds."""
        found, met = self.result.diagnostics, self.result.stop_reason is ipcore.StopReason.CRITERION_MET
        return [
            f"{self.result.degree}{'' if met else ' (cap)'}",
            f"{found.d_dist:.4f}",
            f"{found.d_smooth:.3f}",
            f"{self.stray:.4f}",
            str(self.components),
            f"{self.seconds:.2f}",
            "good" if self.good else "",
            self.proved,
            f"{self.proof_seconds:.2f}",
        ]

    @property
    def proved(self) -> str:
        """Return what is proved, in a few words."""
        if self.proof.components is not None:
            return f"{self.proof.components}, Euler {self.proof.euler}"
        return "near the points" if self.proof.holds else "–"


def usable(given: sets.PointSet) -> sets.PointSet:
    """Return the set, without its normals if one of them is 0."""
    if given.normals is not None and not given.normals.any(axis=1).all():
        return replace(given, normals=None)
    return given


def fitted(given: sets.PointSet, way: str) -> Scored:
    """Fit a set as `FITS[way]` says, and measure the zero set."""
    options = dict(FITS[way])
    if way != "default":
        options["max_degree"] = LINEAR_CAP[given.dimension]
    started = process_time()
    result = ipcore.fit(given.points, given.normals, ipcore.FitOptions.of(measure_zero_set=False, **options))
    seconds = process_time() - started
    lines = {2: 240, 3: 88}[given.dimension]
    whole = ipcore.zero_set(result.polynomial, resolution=lines, data=given.points, restrict=False, cap=False)
    components = len(np.unique(whole.vertex_components()[whole.cells]))
    started = process_time()
    proof = prove(result.polynomial, given.points, result.polynomial.frame.scale)
    return Scored(result, seconds, stray_by_distance(whole, given.points), components, proof, process_time() - started)


def stray_by_distance(whole: ipcore.ZeroSet, points: ipcore.FloatArray) -> float:
    """Return the share of a zero set's length or area that is far from all points (N, d); 1 if it is empty.

    Far is more than 0.10 (2D) or 0.12 (3D) mean radii and 2.5 median spacings, even in a gap of a sparse sample, where
    a report does not count it: so scores can be compared with those of other versions and of other libraries.
    """
    if not len(whole.cells):
        return 1.0
    size = np.linalg.norm(whole.cell_normals(), axis=1)
    distance, _ = cKDTree(points).query(whole.vertices[whole.cells].mean(axis=1))
    spacing = float(np.median(np.asarray(cKDTree(points).query(points, 2)[0])[:, 1]))
    far = distance > max({2: 0.10, 3: 0.12}[points.shape[1]] * ipcore.Frame.of(points).scale, 2.5 * spacing)
    return float(size[far].sum() / size.sum())


Scores = dict[str, dict[str, Scored]]  # by name of the set, then of the fit


def measured(given: Sequence[sets.PointSet], ways: Sequence[str]) -> Scores:
    """Fit all sets in these ways, print their rows, and return the scores."""
    scored: Scores = {}
    for one in given:
        scored[one.name] = {way: fitted(one, way) for way in ways}
        for row in rows([one], scored):
            print(" | ".join(row), flush=True)
    return scored


def rows(given: Sequence[sets.PointSet], scored: Scores) -> Iterator[list[str]]:
    """Yield a table row for each set and fit."""
    for one in given:
        for way, fit in scored[one.name].items():
            yield [one.name if way == "3L" else "", way, *fit.cells()]


def summary(given: Sequence[sets.PointSet], scored: Scores) -> Iterator[str]:
    """Yield one line of counts and medians for each kind of fit, and one about degrees."""
    for_closed = [scored[one.name] for one in given if one.closed]
    for way in for_closed[0]:
        good = sum(one[way].good for one in for_closed)
        times = [
            median([one[way].seconds for one in for_closed if one[way].result.polynomial.dimension == d] or [0.0])
            for d in (2, 3)
        ]
        where = f"{good} of {len(for_closed)} closed shapes good"
        yield f"- {way}: {where}; median {times[0]:.2f} s (2D), {times[1]:.1f} s (3D)"

    proofs = [one["default"].proof for one in for_closed]
    yield (
        f"- default: a proof that all zeros are near the points for {sum(proof.holds for proof in proofs)} of "
        f"{len(proofs)} closed shapes, of the components and the Euler characteristic for "
        f"{sum(proof.components is not None for proof in proofs)}"
    )
    yield from (f"- {name}: {places}" for name, places in unproved(given, scored))

    both = [one for one in for_closed if one["3L"].result.stop_reason is ipcore.StopReason.CRITERION_MET]
    if both:
        quotients = [one["default"].result.degree / one["3L"].result.degree for one in both]
        yield (
            f"- degree over that of plain 3L, where that meets the rule ({len(both)} shapes): "
            f"median {median(quotients):.2f}, largest {max(quotients):.2f}"
        )


def unproved(given: Sequence[sets.PointSet], scored: Scores) -> Iterator[tuple[str, str]]:
    """Yield for each default fit without a whole proof what is missing, and where."""
    for one in given:
        proof = scored[one.name]["default"].proof
        if proof.uncleared:
            missing = "not shown to be smooth" if proof.holds else "zeros away from the points not excluded"
            first = proof.uncleared[0]
            centre = ", ".join(f"{x:.4g}" for x in first.centre)
            more = f" and {len(proof.uncleared) - 1} more" if len(proof.uncleared) > 1 else ""
            yield one.name, f"{missing}, at ({centre}) within {first.radius:.3g}{more}"


def picture(name: str, shown: Sequence[sets.PointSet], scored: Scores) -> None:
    """Draw sets in six rows, each set fitted by plain 3L and by default."""
    figure, axes = plot.new(6, len(shown) // 3, 1.9)
    panels = ((given, way) for given in shown for way in ("3L", "default"))
    for axis, (given, way) in zip(axes, panels, strict=True):
        one = scored[given.name][way]
        draw = plot.outline if given.dimension == 2 else plot.surface
        draw(axis, given, one.result.polynomial)
        axis.set_title(f"{given.name}: {way}, degree {one.result.degree}")
    figure.savefig(HERE / "quality" / name, dpi=110)


def section(title: str, given: Sequence[sets.PointSet], scored: Scores) -> str:
    """Return a heading, the summary, and the table."""
    return "\n\n".join([title, "\n".join(summary(given, scored)), table(HEADS, rows(given, scored))])


def on_real_data() -> str:
    """Fit all sets of the index, and return the page down to their tables."""
    given = [usable(sets.load(str(entry["name"])).sample(MAX_POINTS)) for entry in sets.index()]
    scored = measured(given, tuple(FITS))
    named = {one.name: one for one in given}
    picture("before-and-after.png", [named[name] for name in PICTURED], scored)
    made = (
        f"Made by `python bench/quality.py` with Python {platform.python_version()} on {platform.machine()}, with one "
        f"thread; sets of more than {MAX_POINTS} points are sampled. Seconds are the processor's. "
        f"The linear fits end at degree {LINEAR_CAP[2]} (2D) and {LINEAR_CAP[3]} (3D). Sets without normals get "
        "estimated ones."
    )
    parts = ["# How good the fits are", (__doc__ or "").split("\n\n", 2)[2].strip(), made]
    parts.append("![Before and after](quality/before-and-after.png)")
    parts.append(section("## Even places of the index", given[::2], scored))
    parts.append(section("## Odd places of the index", given[1::2], scored))
    return "\n\n".join(parts)


def on_held_back() -> str:
    """Fit the shapes made here, and return the page from their section on."""
    given = held_back.shapes()
    scored = measured(given, HELD_BACK_FITS)
    picture("held-back.png", [one for one in given if one.dimension == 2], scored)
    conclusions = CONCLUSIONS.read_text(encoding="utf-8").strip()
    return "\n\n".join([section(HELD_BACK, given, scored), "![Letters held back](quality/held-back.png)", conclusions])


def main() -> None:
    """Fit and print; write the page, or its end, unless only some sets were asked for."""
    target = HERE / "QUALITY.md"
    match sys.argv[1:]:
        case []:
            start = on_real_data()
        case ["--held-back"]:
            start = target.read_text(encoding="utf-8").partition(f"\n{HELD_BACK}\n")[0].strip()
        case names:
            measured([usable(sets.load(name).sample(MAX_POINTS)) for name in names], tuple(FITS))
            return
    target.write_text(f"{start}\n\n{on_held_back()}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
