from typing import Any

import pytest

from ipcore.constraints.registry import Constraints
from ipcore.errors import InvalidOptionsError
from ipcore.options.choices import Collinear, Criterion
from ipcore.options.fit_options import FitOptions
from ipcore.polynomial.univariate import Basis


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_degree", 0),
        ("max_degree", 41),
        ("max_degree", 4.0),
        ("max_degree", True),
        ("layer_distance", 0.0),
        ("layer_distance", 0.31),
        ("layer_distance", float("nan")),
        ("t1", -1e-9),
        ("t1", "0.01"),
        ("t2", 1.01),
        ("collinear_tol", -1.0),
        ("neighbours", 2),
        ("basis", "legendre"),
        ("constraints", "4l"),
        ("gradient_weight", 0.0),
        ("criterion", "aic"),
        ("granularity", "column"),
        ("factor", "householder"),
        ("collinear", "forget"),
        ("ridge", True),
        ("ridge_matrix", None),
        ("ridge_strength", 0.0),
    ],
)
def test_a_wrong_value_is_refused_by_name(name: str, value: Any) -> None:  # noqa: ANN401 - wrong on purpose
    with pytest.raises(InvalidOptionsError, match=name) as caught:
        FitOptions(**{name: value})
    assert caught.value.at == (name,)


def test_degree_cap_depends_on_the_dimension() -> None:
    assert FitOptions().degree_cap(2) == 20
    assert FitOptions().degree_cap(3) == 16
    assert FitOptions(max_degree=30).degree_cap(2) == 30
    with pytest.raises(InvalidOptionsError, match="at most 20 for 3D points, not 21"):
        FitOptions(max_degree=21).degree_cap(3)


@pytest.mark.parametrize(
    ("given", "at"),
    [
        ({"constraints": "taubin", "ridge": "full"}, "ridge"),
        ({"constraints": "taubin", "criterion": "gcv"}, "criterion"),
        ({"constraints": "taubin", "criterion": "loo"}, "criterion"),
        ({"collinear": "ridge"}, "collinear"),
        ({"collinear": "ridge", "ridge": "full"}, "collinear"),
        ({"collinear": "drop", "ridge": "selective"}, "collinear"),
        ({"preset": "journal"}, "preset"),
        ({"degree": 4}, "degree"),
    ],
)
def test_contradictions_and_unknown_names_are_refused(given: dict[str, Any], at: str) -> None:
    with pytest.raises(InvalidOptionsError, match=at) as caught:
        FitOptions.of(**given)
    assert caught.value.at == (at,)


def test_names_stand_for_members() -> None:
    options = FitOptions.of(constraints="5l", criterion="loo", basis="chebyshev", ridge="selective")
    assert options.constraints is Constraints.FIVE_LAYER
    assert options.criterion is Criterion.LOO
    assert options.basis is Basis.CHEBYSHEV
    assert options.on_collinear is Collinear.RIDGE
    assert FitOptions().on_collinear is Collinear.DROP
    assert FitOptions(collinear="keep").on_collinear is Collinear.KEEP  # type: ignore[arg-type] # a name is taken


def test_presets_are_where_options_start_from() -> None:
    assert FitOptions.of() == FitOptions() == FitOptions.of("default")
    paper = FitOptions.of("paper")
    assert (paper.granularity, paper.factor, paper.ridge) == ("monomial", "gram-schmidt", "full")
    assert (paper.layer_distance, paper.t1, paper.t2) == (0.05, 0.01, 0.95)
    assert paper.on_collinear is Collinear.DROP
    assert FitOptions.of("paper", ridge="none").ridge == "none"
    assert FitOptions(**paper.to_dict()) == paper


@pytest.mark.parametrize(
    ("given", "holds", "from_moments"),
    [
        ({}, False, False),  # not linear
        ({"geometric": False}, False, True),
        ({"geometric": False, "signs": True}, False, False),
        ({"constraints": "5l"}, False, True),
        ({"constraints": "3l+gradient"}, False, False),
        ({"constraints": "min-var"}, True, False),
        ({"constraints": "taubin"}, True, False),
        ({"criterion": "gcv"}, False, True),
        ({"criterion": "loo"}, True, False),
        ({"factor": "moments"}, False, True),
        ({"factor": "tsqr"}, False, False),
        ({"factor": "block"}, True, False),
        ({"factor": "gram-schmidt"}, True, False),
    ],
)
def test_options_tell_what_a_linear_fit_holds_and_what_moments_determine(
    given: dict[str, Any], *, holds: bool, from_moments: bool
) -> None:
    options = FitOptions.of(**given)
    assert options.holds_design_matrix is holds
    assert options.fits_from_moments is from_moments


# The options beside which these act; beside others they are refused.
ACTING: dict[str, dict[str, Any]] = {
    "layer_distance": {"geometric": False},
    "gradient_weight": {"constraints": "gradient-one"},
    "collinear_tol": {"geometric": False},
    "ridge_strength": {"ridge": "full"},
}


@pytest.mark.parametrize(
    ("name", "edge", "over"),
    [
        ("layer_distance", 0.3, 0.3001),
        ("gradient_weight", 100.0, 100.1),
        ("t2", 1.0, 1.001),
        ("t2", -1.0, -1.001),
        ("collinear_tol", 1.0, 1.001),
        ("collinear_tol", 0.0, -1e-9),
        ("ridge_strength", 1e6, 1.1e6),
        ("angle_weight", 1.0, 1.001),
        ("neighbours", 3, 2),
        ("neighbours", 100, 101),
        ("max_degree", 40, 41),
    ],
)
def test_ranges_include_their_ends(name: str, edge: float, over: float) -> None:
    acting = ACTING.get(name, {})
    assert getattr(FitOptions.of(**acting | {name: edge}), name) == edge
    with pytest.raises(InvalidOptionsError, match=f"{name} must be"):
        FitOptions.of(**acting | {name: over})


@pytest.mark.parametrize(
    ("given", "at"),
    [
        ({"geometric": True, "criterion": "gcv"}, "geometric"),
        ({"signs": True, "ridge": "full"}, "signs"),
        ({"robust": True, "geometric": False}, "robust"),
    ],
)
def test_linear_fits_are_refused_what_only_others_have(given: dict[str, Any], at: str) -> None:
    with pytest.raises(InvalidOptionsError) as caught:
        FitOptions.of(**given)
    assert caught.value.at == (at,)
