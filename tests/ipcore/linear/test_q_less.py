"""Fits that never hold M, against the block factorisation that does."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, FitResult, Moments, StopReason, shapes
from ipcore._typing import FloatArray
from ipcore.errors import InvalidOptionsError
from ipcore.linear.dense import DenseFit
from ipcore.linear.q_less import MAX_UNCORRECTED_CONDITION, QLessFit
from ipcore.linear.row_source import MAX_CONDITION_OF_MOMENTS, MAX_CONDITION_WITH_ROWS, DataRows
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check as check_points
from ipcore.polynomial import graded
from tests.ipcore.linear.rough_shapes import rough


def fitted(points: FloatArray, normals: FloatArray, factor: str, **given: Any) -> FitResult:  # noqa: ANN401 - options
    options: dict[str, Any] = {
        "criterion": "none",
        "geometric": False,
        "measure_zero_set": False,
        "factor": factor,
    } | given
    return ipcore.fit(points, normals, FitOptions.of(**options))


@pytest.mark.parametrize("constraints", ["3l", "5l"])
@pytest.mark.parametrize(("d", "degree"), [(2, 12), (3, 9)])
def test_moments_give_the_fits_of_the_block_factorisation(d: int, degree: int, constraints: str) -> None:
    points, normals = rough(d)
    one, other = (
        fitted(points, normals, factor, max_degree=degree, constraints=constraints) for factor in ("moments", "block")
    )
    for a, b in zip(one.steps, other.steps, strict=True):
        # what squaring the condition leaves, down to where a refinement sets in
        tolerance = max(1e-11, min(a.condition, MAX_UNCORRECTED_CONDITION) ** 2 * 1e-18)
        assert (a.degree, a.columns) == (b.degree, b.columns)
        assert a.d_dist == pytest.approx(b.d_dist, rel=tolerance)
        assert a.d_smooth == pytest.approx(b.d_smooth, rel=tolerance)
        assert a.gcv == pytest.approx(b.gcv, rel=max(1e-9, tolerance))
    assert one.polynomial.basis == other.polynomial.basis


def test_where_the_condition_is_too_bad_the_rows_themselves_are_factored() -> None:
    points, normals = rough(2)
    data = OrientedPoints.of(check_points(points, normals), 12)
    options = FitOptions.of(factor="moments", criterion="none")

    class Watched(DataRows):
        """Records which passes over the rows are made."""

        passes: list[str] = []  # noqa: RUF012 - of this one test

        def from_rows(self, degree: int) -> Any:  # noqa: ANN401 - as the one above
            self.passes.append("rows")
            return super().from_rows(degree)

        def normal_residuals(self, degree: int, A: FloatArray) -> Any:  # noqa: ANN401 - as the one above
            self.passes.append("residuals")
            return super().normal_residuals(degree, A)

    fitter = QLessFit(data, options, 20, Watched(data, options))
    block = fitted(points, normals, "block", max_degree=20)
    refined, factored = [], []
    for step in block.steps:
        Watched.passes.clear()
        fit = fitter.raise_to(graded.count(2, step.degree))
        assert fit is not None
        f, expected = fit.polynomial(data.points), np.sqrt(step.rss / (3 * len(points)))
        assert np.sqrt(np.mean(f**2)) < 3.0 * expected
        assert fit.rss == pytest.approx(step.rss, rel=1e-6)
        if "rows" in Watched.passes:
            factored.append(fit.condition)
        elif "residuals" in Watched.passes:
            refined.append(fit.condition)
    assert len(refined) == 1  # with all higher degrees that R has
    assert len(factored) == 1  # from then on R comes from the rows
    assert MAX_UNCORRECTED_CONDITION < refined[0] < MAX_CONDITION_WITH_ROWS < factored[0]


@pytest.mark.parametrize("factor", ["moments", "tsqr"])
@pytest.mark.parametrize(
    "given",
    [
        {"ridge": "full", "ridge_strength": 1e-3},
        {"ridge": "selective", "collinear_tol": 1e-3, "ridge_strength": 1e-3},
        {"collinear_tol": 1e-3},
        {"granularity": "monomial", "max_degree": 5},
        {"criterion": "gcv"},
        {"criterion": "bic"},
    ],
    ids=lambda given: next(iter(given.items()))[0] + "=" + str(next(iter(given.items()))[1]),
)
def test_ridges_dropped_columns_and_criteria_are_those_of_the_block_factorisation(
    factor: str, given: dict[str, Any]
) -> None:
    points, normals = rough(3, 2500)
    one, other = (fitted(points, normals, name, **{"max_degree": 7} | given) for name in (factor, "block"))
    assert (one.degree, one.stop_reason) == (other.degree, other.stop_reason)
    for a, b in zip(one.steps, other.steps, strict=True):
        assert (a.columns, a.dropped, a.ridged) == (b.columns, b.dropped, b.ridged)
        assert (a.d_dist, a.gcv) == pytest.approx((b.d_dist, b.gcv), rel=1e-7)


@pytest.mark.parametrize("constraints", ["3l+gradient", "gradient-one"])
def test_rows_of_gradients_are_factored_in_chunks_too(constraints: str) -> None:
    points, normals = rough(3, 6000)
    one, other = (fitted(points, normals, name, max_degree=6, constraints=constraints) for name in ("tsqr", "block"))
    for a, b in zip(one.steps, other.steps, strict=True):
        assert a.d_dist == pytest.approx(b.d_dist, rel=1e-10)


def test_columns_that_are_collinear_on_layers_of_an_algebraic_shape_are_left_out() -> None:
    points, normals = shapes.sphere().sample(6000)  # three spheres: degree 6 vanishes on all of them
    for factor in ("moments", "tsqr"):
        result = fitted(points, normals, factor, max_degree=7)
        assert [step.dropped for step in result.steps] == [0, 0, 0, 0, 0, 1, 4]
        assert result.diagnostics.distance_max < 1e-9


def test_threads_change_nothing() -> None:
    points, normals = rough(3, 20_000)
    options = FitOptions.of(geometric=False, measure_zero_set=False, max_degree=6)
    one, two = (ipcore.fit(points, normals, options, threads=threads) for threads in (1, 2))
    np.testing.assert_allclose(one.polynomial.coefficients, two.polynomial.coefficients, rtol=1e-9, atol=1e-12)


def test_options_that_need_all_rows_are_refused_with_the_reason() -> None:
    with pytest.raises(InvalidOptionsError, match="criterion loo needs the rows that factor tsqr does not keep"):
        FitOptions.of(factor="tsqr", criterion="loo")
    with pytest.raises(InvalidOptionsError, match="constraints min-max needs the rows"):
        FitOptions.of(factor="moments", constraints="min-max")
    with pytest.raises(InvalidOptionsError, match="take tsqr"):
        FitOptions.of(factor="moments", constraints="gradient-one")


def test_moments_alone_end_where_squaring_the_condition_would_show() -> None:
    points, normals = rough(2)
    result = Moments.of(points, normals, degree=30).fit(FitOptions.of(factor="moments", criterion="none"))
    assert result.stop_reason is StopReason.ILL_CONDITIONED
    assert max(step.condition for step in result.steps) <= MAX_CONDITION_OF_MOMENTS
    assert result.degree < 30
    assert any("Moments alone" in warning.message for warning in result.warnings)


def test_a_sample_damps_as_much_as_all_the_points_that_it_stands_for() -> None:
    held = OrientedPoints.of(check_points(*rough(2, 300)), 12)
    twice = replace(held, points=np.tile(held.points, (2, 1)), normals=np.tile(held.normals, (2, 1)), count=600)
    options = FitOptions.of(ridge="full", ridge_strength=1e-2)
    fit = QLessFit(replace(held, count=600), options, 5, DataRows(twice, options)).raise_to(21)
    dense = DenseFit(twice, options, 5).raise_to(21)
    assert fit is not None
    np.testing.assert_allclose(fit.polynomial.coefficients, dense.polynomial.coefficients, atol=1e-9)
    assert fit.degrees_of_freedom == pytest.approx(dense.degrees_of_freedom, rel=1e-9)
    assert fit.rss == pytest.approx(dense.rss, rel=1e-9)
    assert fit.rows == dense.rows == 1800


def test_the_ridged_solution_of_an_ill_conditioned_system_is_that_of_the_dense_fit() -> None:
    data = OrientedPoints.of(check_points(*rough(2, 500)), 12)
    options = FitOptions.of(factor="moments", ridge="full", ridge_strength=1e-12)
    fit = QLessFit(data, options, 12, DataRows(data, options)).raise_to(graded.count(2, 12))
    dense = DenseFit(data, options, 12).raise_to(graded.count(2, 12))
    assert fit is not None
    assert fit.condition > MAX_UNCORRECTED_CONDITION  # where a fit without a ridge is corrected
    np.testing.assert_allclose(fit.polynomial(data.points), dense.polynomial(data.points), atol=1e-10)
