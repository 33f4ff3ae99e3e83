"""Fig. 1: over-fitting at a high degree, and the effect of full and of selective ridge regression."""

from collections.abc import Iterator
from typing import Any

from matplotlib.figure import Figure

import ipcore
from evidence.plot import new, outline, surface
from evidence.shapes import fitted
from evidence.table import table
from sets import PointSet, load

SURFACE, OUTLINE = "bunny_npm", "mp7_bone"
DEGREES = {2: (4, 8, 12, 16), 3: (4, 8, 10)}
STRENGTHS = (1e-8, 1e-6, 1e-4, 1e-3, 1e-2)
VARIANTS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("none", {}),
    *((f"full, κ = {k:.0e}", {"ridge": "full", "ridge_strength": k}) for k in STRENGTHS),
    *(
        (f"full, D = I, κ = {k:.0e}", {"ridge": "full", "ridge_matrix": "identity", "ridge_strength": k})
        for k in (1e-6, 1e-3)
    ),
    *(
        (f"selective, κ = {k:.0e}", {"ridge": "selective", "ridge_strength": k, "collinear_tol": 1e-3})
        for k in (1e-4, 1e-2)
    ),
)
PICTURED_RIDGE: dict[str, Any] = {"ridge": "full", "ridge_strength": 1e-3}


def rows() -> str:
    """Return a table of the effect of each ridge on closeness, stray share and condition."""
    heads = ["set", "degree", "ridge", "D_dist", "D_smooth", "stray", "pieces", "ridged", "condition", "max/min rᵢᵢ"]
    lines = []
    for name in (OUTLINE, SURFACE):
        given = load(name)
        degree = DEGREES[given.dimension][-1]
        lines += [
            [name, str(degree), variant, *_measures(_at(given, degree, options))] for variant, options in VARIANTS
        ]
    return table(heads, lines)


def _measures(fit: ipcore.FitResult) -> Iterator[str]:
    found, last = fit.diagnostics, fit.steps[-1]
    yield f"{found.d_dist:.4f}"
    yield f"{found.d_smooth:.3f}"
    yield "" if found.stray is None else f"{found.stray:.2f}"
    yield str(found.components)
    yield str(last.ridged)
    yield f"{last.condition:.0e}"
    yield f"{last.diagonal_ratio:.0e}"


def figure() -> Figure:
    """Return the figure: rising degrees without ridge, then the higher ones with ridge."""
    panels = [(name, degree, options) for name in (OUTLINE, SURFACE) for degree, options in _panels(name)]
    picture, axes = new(2, len(panels) // 2, 2.0)
    for axis, (name, degree, options) in zip(axes, panels, strict=True):
        given = load(name)
        fit = _at(given, degree, options)
        (outline if given.dimension == 2 else surface)(axis, given, fit.polynomial)
        axis.set_title(f"degree {degree}{', ridge' if options else ''}: D_dist {fit.diagnostics.d_dist:.3f}")
    return picture


def _panels(name: str) -> Iterator[tuple[int, dict[str, Any]]]:
    degrees = DEGREES[load(name).dimension][-3:]
    yield from ((degree, {}) for degree in degrees)
    yield from ((degree, PICTURED_RIDGE) for degree in degrees[1:])


def _at(given: PointSet, degree: int, options: dict[str, Any]) -> ipcore.FitResult:
    return fitted(given, criterion="none", max_degree=degree, **options)
