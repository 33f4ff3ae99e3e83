"""The preset that follows Zheng, Takamatsu and Ikeuchi (ACCV 2007) to the letter."""

from typing import Any

import numpy as np
import pytest
from skimage import data, measure

import ipcore
from ipcore import FitOptions, shapes
from ipcore._typing import FloatArray
from ipcore.polynomial import graded

QUIET: dict[str, Any] = {"measure_zero_set": False}


def cell() -> FloatArray:
    return np.asarray(max(measure.find_contours(data.cell().astype(float), 110.0), key=len))


def trefoil(count: int = 400) -> FloatArray:
    angle = 2.0 * np.pi * np.arange(count) / count
    radius = 1.0 + 0.3 * np.cos(3.0 * angle)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def test_every_column_of_table_1_is_a_possible_stop() -> None:
    options = FitOptions.of("paper", t1=0.0, max_degree=13, **QUIET)
    steps = ipcore.fit(trefoil(), options=options).steps
    assert [step.alpha for step in steps] == list(range(2, 106))
    assert [steps[alpha - 2].degree for alpha in (28, 54, 92)] == [6, 9, 13]  # the stops of Fig. 3
    assert graded.exponents(2, 13)[92 - 1].tolist() == [13, 0]  # x¹³ alone


def test_the_answer_has_zeros_for_the_columns_that_are_still_to_come() -> None:
    result = ipcore.fit(trefoil(), options=FitOptions.of("paper", **QUIET))
    step, a = result.steps[-1], result.polynomial.coefficients
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    assert step.alpha < len(a) == graded.count(2, step.degree)
    assert (a[step.alpha :] == 0.0).all()
    assert (a[: step.alpha] != 0.0).all()
    assert result.diagnostics.d_dist == pytest.approx(step.d_dist, rel=1e-6)


def test_a_real_cell_stops_in_the_middle_of_no_form_but_at_a_column() -> None:
    column = ipcore.fit(cell(), options=FitOptions.of("paper", **QUIET))
    form = ipcore.fit(cell(), options=FitOptions(**QUIET))
    assert column.stop_reason is form.stop_reason is ipcore.StopReason.CRITERION_MET
    assert column.steps[-1].alpha <= form.steps[-1].alpha


@pytest.mark.parametrize("strength", [1e-14, 1e-10, 1e-6])
@pytest.mark.parametrize("matrix", ["invariant", "identity"])
def test_the_column_does_not_depend_on_a_small_kappa(strength: float, matrix: str) -> None:
    options = FitOptions.of("paper", ridge_strength=strength, ridge_matrix=matrix, **QUIET)
    plain = FitOptions.of("paper", ridge="none", **QUIET)
    damped, undamped = (ipcore.fit(trefoil(), options=o).steps[-1] for o in (options, plain))
    assert damped.alpha == undamped.alpha
    assert damped.ridged == damped.columns
    assert undamped.ridged == 0


def test_the_loss_of_orthogonality_is_reported_and_warned_of() -> None:
    low = ipcore.fit_fixed(trefoil(), options=FitOptions.of("paper", ridge="none", **QUIET), degree=4)
    high = ipcore.fit_fixed(trefoil(), options=FitOptions.of("paper", ridge="none", **QUIET), degree=16)
    assert low.diagnostics.orthogonality_loss is not None
    assert high.diagnostics.orthogonality_loss is not None
    assert low.diagnostics.orthogonality_loss < 1e-9
    assert high.diagnostics.orthogonality_loss > 1e-3
    assert any("lost orthogonality" in warning.message for warning in high.warnings)
    assert not any("lost orthogonality" in warning.message for warning in low.warnings)
    block = ipcore.fit_fixed(trefoil(), options=FitOptions(**QUIET), degree=16, method="3l")
    assert block.diagnostics.orthogonality_loss is None
    assert block.steps[0].rss < high.steps[0].rss  # least squares has the least


def test_columns_one_by_one_pass_through_the_fits_of_complete_degrees() -> None:
    points, normals = shapes.torus().sample(800)
    by_form = ipcore.fit(points, normals, FitOptions.of(t1=0.0, max_degree=5, geometric=False, **QUIET)).steps
    by_column = ipcore.fit(points, normals, FitOptions.of(t1=0.0, max_degree=5, granularity="monomial", **QUIET)).steps
    complete = {step.alpha: step for step in by_column}
    for step in by_form:
        assert complete[step.alpha].degree == step.degree
        assert complete[step.alpha].rss == pytest.approx(step.rss, rel=1e-9)
        assert complete[step.alpha].d_dist == pytest.approx(step.d_dist, rel=1e-8)


def test_collinear_columns_of_a_plane_curve_on_a_conic_are_eliminated() -> None:
    points, normals = shapes.circle().sample(200)  # on the circle x² + y² = 1, but the layers lie off it
    options = FitOptions.of("paper", constraints="gradient-one", t1=0.0, max_degree=6, ridge="none", **QUIET)
    last = ipcore.fit(points, normals, options).steps[-1]
    # value and gradient vanish for (x² + y² − 1)² times anything: 1, 3, 6 columns of degree 4, 5, 6 are explained
    assert (last.dropped, last.alpha) == (6, 28)


def test_the_papers_ratio_is_a_lower_bound_of_the_condition() -> None:
    for step in ipcore.fit(trefoil(), options=FitOptions.of("paper", t1=0.0, max_degree=8, **QUIET)).steps[2:]:
        assert step.diagonal_ratio is not None
        assert step.diagonal_ratio >= 1.0
    last = ipcore.fit_fixed(trefoil(), options=FitOptions.of("paper", **QUIET), degree=12).steps[-1]
    assert last.diagonal_ratio is not None
    assert last.diagonal_ratio < last.condition / 10
