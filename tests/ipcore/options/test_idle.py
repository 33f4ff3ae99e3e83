"""Every option acts, or is refused with its name: enumerated over options and kinds of fits."""

from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, InvalidOptionsError, shapes
from ipcore._typing import FloatArray

# What is chosen, by kind of fit.
FITS: dict[str, dict[str, Any]] = {
    "geometric": {},
    "signs": {"geometric": False, "signs": True},
    "linear": {"geometric": False},
    "5l": {"constraints": "5l"},
    "3l+gradient": {"constraints": "3l+gradient"},
    "gradient-one": {"constraints": "gradient-one"},
    "min-max": {"constraints": "min-max"},
    "min-var": {"constraints": "min-var"},
    "taubin": {"constraints": "taubin", "criterion": "none"},
    "gcv": {"criterion": "gcv"},
    "block": {"factor": "block"},
    "eq5": {"factor": "gram-schmidt", "granularity": "monomial"},
    "full ridge": {"ridge": "full"},
    "selective ridge": {"ridge": "selective", "collinear_tol": 0.25},
    "kept columns": {"factor": "block", "collinear": "keep"},
    "none": {"geometric": False, "criterion": "none"},
}
# A value of each option that is not its default, and that changes the result wherever the option acts.
OTHER: dict[str, Any] = {
    "max_degree": 3,
    "layer_distance": 0.2,
    "gradient_weight": 0.5,
    "t1": 0.2,
    "t2": 0.99999,
    "collinear_tol": 0.3,
    "ridge_matrix": "identity",
    "ridge_strength": 0.1,
    "angle_weight": 0.05,
    "basis": "chebyshev",
    "measure_zero_set": False,
}
BASE: dict[str, Any] = {"max_degree": 6}


def noisy() -> tuple[FloatArray, FloatArray]:
    points, normals = shapes.superellipse().sample(160)
    shift = np.random.default_rng(0).normal(scale=0.008, size=points.shape)
    return points + shift, normals


def what_came_out(options: FitOptions) -> list[Any]:
    """Return the coefficients and all figures of a fit, without times and without the options themselves."""
    result = ipcore.fit(*noisy(), options)
    steps = [{name: value for name, value in asdict(step).items() if name != "seconds"} for step in result.steps]
    return [result.polynomial.coefficients.tolist(), steps, asdict(result.diagnostics)]


@pytest.mark.parametrize("name", OTHER)
@pytest.mark.parametrize("fit", FITS)
def test_an_option_changes_the_result_or_is_refused_by_name(fit: str, name: str) -> None:
    chosen = BASE | FITS[fit]
    other = FitOptions(**chosen)
    if is_refused(name, chosen | {name: OTHER[name]}):
        object.__setattr__(other, name, OTHER[name])  # behind the check it changes nothing, to the bit
        assert what_came_out(other) == what_came_out(FitOptions(**chosen))
    else:
        other = FitOptions(**chosen | {name: OTHER[name]})
        assert what_came_out(other) != what_came_out(FitOptions(**chosen))


def is_refused(name: str, options: dict[str, Any]) -> bool:
    """Return whether these options are refused, for `name` has no effect."""
    try:
        FitOptions(**options)
    except InvalidOptionsError as error:
        return error.at == (name,) and f"{name} has no effect" in error.message
    return False


def test_robust_is_for_other_than_linear_fits() -> None:
    for fit in ("geometric", "signs"):
        assert FitOptions(**FITS[fit], robust=True).robust
    with pytest.raises(InvalidOptionsError, match="robust needs"):
        FitOptions(geometric=False, robust=True)


def test_neighbours_act_where_normals_are_estimated() -> None:
    points = np.random.default_rng(0).permutation(noisy()[0])
    few, many = (ipcore.fit(points, options=FitOptions(neighbours=k, max_degree=2)) for k in (4, 40))
    assert few.diagnostics.d_smooth != many.diagnostics.d_smooth


def test_a_default_value_may_be_said_where_it_does_not_act() -> None:
    assert not FitOptions.of(layer_distance=0.05, ridge_strength=1e-4, t2=0.95, criterion="gcv").on_geometric


def test_an_option_of_a_preset_that_does_not_act_beside_those_given_is_no_error() -> None:
    assert FitOptions.of("paper", ridge="none").ridge_strength == FitOptions().ridge_strength
    with pytest.raises(InvalidOptionsError, match="ridge_strength has no effect"):
        FitOptions.of("paper", ridge="none", ridge_strength=0.5)
