"""The error against a backward-stable solve, by degree: D_dist of other factorisations against that of `block`."""

from functools import partial
from pathlib import Path
from typing import Any

import ipcore
from contest import clouds
from contest.clouds import Cloud
from contest.process import ContenderRef, run_alone
from contest.rounds import Medians, Scores
from contest.target import Target, at_most
from contest.trial import Contender, Trial
from evidence.table import table

COUNT = 5000  # points: block holds M and Q, 0.25 GB at degree 16
CAP = {2: 24, 3: 16}
STABLE, OTHERS = "block", ("moments", "tsqr", "auto")
TOLERANCE = 1e-6
TARGET_DEGREE = 12  # the target is about degrees up to this one

Steps = dict[str, list[tuple[int, float, float]]]  # by factorisation: degree, D_dist, condition


def steps(cloud: Cloud) -> Steps:
    """Fit by all factorisations, and return the steps of each; one that is refused for this set has none."""
    found: Steps = {}
    for way in (STABLE, *OTHERS):
        try:
            fit = _fitted(cloud, way)
        except ipcore.IPCoreError:
            found[way] = []
        else:
            found[way] = [(step.degree, step.d_dist, step.condition) for step in fit.steps]
    return found


def _fitted(cloud: Cloud, way: str) -> ipcore.FitResult:
    cap = CAP[cloud.points.shape[1]]
    plain: dict[str, Any] = {"signs": False, "geometric": False, "measure_zero_set": False, "criterion": "none"}
    return ipcore.fit(cloud.points, cloud.normals, ipcore.FitOptions.of(max_degree=cap, factor=way, **plain))


def _ready(name: str, folder: Path) -> Trial:
    cloud = Cloud.load(folder, name)
    return Trial(lambda: None, lambda: steps(cloud), lambda found: {"steps": found})


CONTENDERS: dict[str, Contender] = {name: partial(_ready, name) for name in clouds.names()}


def contest(folder: Path, seconds: float) -> Scores:  # noqa: ARG001 - nothing is timed, so one run is enough
    """Compare the factorisations on every set."""
    found = {}
    for name in clouds.names():
        Cloud.of(clouds.named(name, COUNT)).save(folder, name)
        found[name] = Medians([run_alone(ContenderRef("agreement", name, folder))])
    return found


def differences(one: Medians, way: str) -> list[tuple[int, float, float]]:
    """Return degree, condition, and the relative difference of D_dist from that of `block`, for every degree."""
    found: Steps = one.found.get("steps", {})
    stable = {degree: (d_dist, condition) for degree, d_dist, condition in found.get(STABLE, [])}
    return [
        (degree, stable[degree][1], abs(d_dist / stable[degree][0] - 1.0))
        for degree, d_dist, _ in found.get(way, [])
        if degree in stable
    ]


def targets(scores: Scores) -> list[Target]:
    """Return, for every set, the largest difference of `auto` up to `TARGET_DEGREE`."""
    lines = []
    for name, one in scores.items():
        short = [row for row in differences(one, "auto") if row[0] <= TARGET_DEGREE]
        worst = max(short, key=lambda row: row[2], default=(0, float("nan"), float("nan")))
        note = f" (at degree {worst[0]}, condition {worst[1]:.0e})"
        what = f"D_dist of auto against block's to degree {TARGET_DEGREE}, relative, {name}"
        lines.append(at_most(what, worst[2], TOLERANCE, note=note))
    return lines


def agreement_as_text(scores: Scores, way: str) -> str:
    """Return a sentence: up to which condition a factorisation agrees with `block` on all sets."""
    rows = sorted((row[1], row[2]) for one in scores.values() for row in differences(one, way))
    if not rows:
        return f"- {way}: not measured."
    bad = [condition for condition, difference in rows if difference > TOLERANCE]
    if not bad:
        return f"- {way}: within {TOLERANCE:.0e} everywhere, up to a condition of {rows[-1][0]:.0e}."
    good = [condition for condition, _ in rows if condition < bad[0]]
    first = f"up to a condition of {good[-1]:.0e}" if good else "nowhere"
    worst = max(rows, key=lambda row: row[1])
    return (
        f"- {way}: within {TOLERANCE:.0e} {first}, and beyond it at {bad[0]:.0e}; at worst {worst[1]:.0e}, at a "
        f"condition of {worst[0]:.0e}."
    )


def shown(scores: Scores) -> str:
    """Return the sentences, and one table for each factorisation."""
    parts = ["\n".join(agreement_as_text(scores, way) for way in OTHERS)]
    parts += [f"{way}:\n\n{_table(scores, way)}" for way in OTHERS if any(differences(s, way) for s in scores.values())]
    failed = [f"- {name}: {one.failed}" for name, one in scores.items() if one.failed]
    return "\n\n".join([*parts, *failed])


def _table(scores: Scores, way: str) -> str:
    cells = {
        name: {degree: f"{difference:.0e} ({condition:.0e})" for degree, condition, difference in differences(one, way)}
        for name, one in scores.items()
    }
    degrees = sorted({degree for column in cells.values() for degree in column})
    lines = [[degree, *(column.get(degree, "") for column in cells.values())] for degree in degrees]
    return table(["degree", *cells], lines)
