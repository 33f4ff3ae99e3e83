"""The sets and the linear fit that all studies share."""

from typing import Any

import ipcore
from sets import PointSet, load

OUTLINES = ("cell", "coin", "nucleus", "mp7_heart", "mp7_bone", "mp7_hammer", "mp7_bird", "mp7_fish", "mp7_apple")
SURFACES = (
    "lemon",
    "bunny_npm",
    "spot",
    "fish_blub",
    "duck_pybullet",
    "kitten_pts",
    "armadillo_od",
    "turbine_blade",
)
SURFACE_POINTS = 4000
CAP = {2: 18, 3: 12}


def everything() -> list[PointSet]:
    """Return the outlines, then the surfaces; surfaces are sampled to `SURFACE_POINTS`."""
    return [load(name).sample(SURFACE_POINTS) for name in (*OUTLINES, *SURFACES)]


def fitted(given: PointSet, **options: Any) -> ipcore.FitResult:  # noqa: ANN401 - whatever `FitOptions.of` takes
    """Return the adaptive linear fit of a set, up to the degree `CAP` of its dimension unless options say otherwise."""
    chosen = ipcore.FitOptions.of(**{"max_degree": CAP[given.dimension], "geometric": False, **options})
    return ipcore.fit(given.points, given.normals, chosen)


def closeness(polynomial: ipcore.ImplicitPolynomial, at: PointSet) -> tuple[float, float]:
    """Return D_dist, in mean radii of `at`, and D_smooth of a polynomial at the points of a set with normals."""
    if at.normals is None:
        raise ValueError(f"{at.name} has no normals")
    distances = abs(polynomial.distance(at.points)).mean() / at.scale
    gradient = polynomial.gradient(at.points)
    size = (gradient**2).sum(axis=1) ** 0.5
    return float(distances), float(((at.normals * gradient).sum(axis=1) / size).mean())
