import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.geometric.subgrid import subgrid_components
from ipcore.polynomial import evaluation, univariate
from ipcore.polynomial.univariate import Basis


def tensor(centre: FloatArray, radius: float) -> FloatArray:
    """Return Chebyshev coefficients (3, …) of ‖t − centre‖² − radius²."""
    d = len(centre)
    out = np.zeros((3,) * d)
    origin = (0,) * d
    for axis, c in enumerate(centre):
        one, two = (tuple(k if other == axis else 0 for other in range(d)) for k in (1, 2))
        out[origin] += 0.5 + c**2  # t² = (1 + T₂)/2
        out[one] -= 2.0 * c
        out[two] += 0.5
    out[origin] -= radius**2
    return out


def on_grid(coefficients: FloatArray, lines: FloatArray) -> FloatArray:
    table = univariate.table(Basis.CHEBYSHEV, lines, len(coefficients) - 1).T
    return evaluation.along_axes(coefficients, [table] * coefficients.ndim)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_ball_between_the_nodes_is_found_at_its_centre(d: int, sign: float) -> None:
    lines = np.linspace(-1.0, 1.0, 21)
    centre = np.array([0.33, -0.27, 0.14][:d])
    a = sign * tensor(centre, 0.02)
    f = on_grid(a, lines)
    assert (sign * f > 0.0).all()  # no node is inside
    t, values = subgrid_components(a, lines, f, np.zeros(f.shape, dtype=np.bool_))
    np.testing.assert_allclose(t, [centre], atol=1e-13)
    np.testing.assert_allclose(values, [-sign * 0.02**2], atol=1e-14)


def test_a_minimum_that_does_not_reach_zero_is_none() -> None:
    lines = np.linspace(-1.0, 1.0, 21)
    a = tensor(np.array([0.33, -0.27]), 0.0)
    a[0, 0] += 1e-6
    f = on_grid(a, lines)
    t, values = subgrid_components(a, lines, f, np.zeros(f.shape, dtype=np.bool_))
    assert t.shape == (0, 2)
    assert values.shape == (0,)
