"""Fig. 5: fixed degrees 2 and 4 against the adaptive degree, for every family of constraints."""

from collections.abc import Iterator
from statistics import median

import numpy as np
from matplotlib.figure import Figure

import ipcore
from evidence.adaptive import met
from evidence.plot import new, outline, surface
from evidence.shapes import everything, fitted
from evidence.table import table
from sets import PointSet, load

T1, T2 = ipcore.FitOptions().t1, ipcore.FitOptions().t2
SHOWN = ("cell", "nucleus", "mp7_heart", "mp7_bone", "lemon", "fish_blub")
FIXED = (2, 4)


def comparison() -> str:
    """Return a table: for each family, D_dist at each choice of degree, and for how many sets it is close enough."""
    sets = everything()
    heads = ["constraints", *(f"degree {n}: D_dist" for n in FIXED), *(f"{n}: good enough" for n in FIXED)]
    heads += ["adaptive: D_dist", "D_smooth", "stray", "degree 2D", "degree 3D", "stopped by the rule", "seconds"]
    return table(heads, [list(_family(family, sets)) for family in ipcore.Constraints])


def _family(family: ipcore.Constraints, sets: list[PointSet]) -> Iterator[str]:
    fixed = {n: [_fixed(given, n, family) for given in sets] for n in FIXED}
    adaptive = [fitted(given, constraints=family) for given in sets]
    seconds = [sum(step.seconds for step in fit.steps) for fit in adaptive]
    yield f"`{family}`"
    yield from (f"{median(fit.diagnostics.d_dist for fit in fixed[n]):.4f}" for n in FIXED)
    yield from (f"{sum(map(close, fixed[n]))} of {len(sets)}" for n in FIXED)
    yield f"{median(fit.diagnostics.d_dist for fit in adaptive):.4f}"
    yield f"{median(fit.diagnostics.d_smooth for fit in adaptive):.3f}"
    yield f"{median(fit.diagnostics.stray or 0.0 for fit in adaptive):.2f}"
    for d in (2, 3):
        yield f"{median(fit.degree for fit in adaptive if fit.polynomial.dimension == d):g}"
    yield f"{sum(map(met, adaptive))} of {len(sets)}"
    yield f"{np.median(seconds):.2f}"


def marks() -> str:
    """Return the paper's marks for the sets of the figure: * moderate, † insufficient, ‡ over-fitting."""
    lines = []
    for name in SHOWN:
        given = load(name)
        own = fitted(given)
        fixed = {n: _fixed(given, n) for n in FIXED}
        cells = [f"{mark(fixed[n], own)} ({fixed[n].diagnostics.d_dist:.4f})" for n in FIXED]
        lines.append([name, *cells, f"{own.degree} ({own.diagnostics.d_dist:.4f})"])
    return table(["set", *(f"degree {n} (D_dist)" for n in FIXED), "adaptive degree"], lines)


def mark(fixed: ipcore.FitResult, own: ipcore.FitResult) -> str:
    """Return the paper's mark of a fit of fixed degree, compared with the fit `own` of the degree that was found."""
    if fixed.degree > own.degree:
        return "‡"
    return "*" if close(fixed) else "†"


def close(fit: ipcore.FitResult) -> bool:
    """Return whether a fit meets the rule's thresholds, whatever ended its search."""
    return fit.diagnostics.d_dist < T1 and fit.diagnostics.d_smooth > T2


def figure() -> Figure:
    """Return the figure of six sets, fitted with degree 2, with degree 4, and with the degree that was found."""
    picture, axes = new(len(FIXED) + 1, len(SHOWN), 2.0)
    for column, name in enumerate(SHOWN):
        given = load(name)
        fits = [*(_fixed(given, n) for n in FIXED), fitted(given)]
        for row, fit in enumerate(fits):
            axis = axes[row * len(SHOWN) + column]
            (outline if given.dimension == 2 else surface)(axis, given, fit.polynomial)
            axis.set_title(f"{name}: " + (f"adaptive, {fit.degree}" if row == len(FIXED) else f"degree {fit.degree}"))
    return picture


def _fixed(
    given: PointSet, degree: int, family: ipcore.Constraints = ipcore.Constraints.THREE_LAYER
) -> ipcore.FitResult:
    return ipcore.fit_fixed(given.points, given.normals, degree=degree, method=family)
