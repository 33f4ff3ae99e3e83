"""The fit that the contests repeat, and how close a polynomial is to points."""

from typing import Any

import numpy as np

import ipcore
from contest.clouds import Cloud

TOP = 12
LINEAR: dict[str, Any] = {"max_degree": TOP, "signs": False, "geometric": False, "criterion": "none"}
FEW = 2000  # points of the warm-up fit: enough for degree 12


def fitted(cloud: Cloud, factor: str = "auto", given: dict[str, Any] | None = None, **more: Any) -> ipcore.FitResult:  # noqa: ANN401 - whatever `FitOptions.of` takes
    """Fit every degree up to TOP, linearly. `given` has more arguments of `ipcore.fit`, which win over the cloud's."""
    options = ipcore.FitOptions.of(factor=factor, **LINEAR | more)
    arguments: dict[str, Any] = {"points": cloud.points, "normals": cloud.normals, "options": options}
    return ipcore.fit(**arguments | (given or {}))


def closeness(polynomial: ipcore.ImplicitPolynomial, cloud: Cloud) -> dict[str, float]:
    """Return D_dist, in mean radii, and D_smooth of a polynomial at the points of a cloud."""
    f, gradient = polynomial.value_and_gradient(cloud.points)
    size = np.linalg.norm(gradient, axis=1)
    scale = ipcore.Frame.of(cloud.points).scale
    cosine = np.einsum("nk,nk->n", gradient, cloud.normals) / size
    return {"d_dist": float(np.mean(np.abs(f) / size)) / scale, "d_smooth": float(cosine.mean())}
