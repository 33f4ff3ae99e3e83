from dataclasses import replace
from functools import cache
from itertools import count

import numpy as np
import pytest

import ipcore
from ipcore import Constraints, FitOptions, StopReason, shapes
from ipcore._typing import FloatArray
from ipcore.fitting import choose_linear_fitter
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check as check_points
from ipcore.polynomial import graded
from ipcore.search import degree_search
from ipcore.search.criteria import DEGREES_PAST_MINIMUM, LastDegree, stopping_criterion
from ipcore.search.degree_search import DegreeSearch, column_counts
from ipcore.search.fitter import PrefixFit

QUICK = FitOptions(measure_zero_set=False)


def noisy(sigma: float, count: int = 400) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return clean points of a superellipse, the same with noise, and normals."""
    points, normals = shapes.superellipse().sample(count)
    return points, points + np.random.default_rng(0).normal(scale=sigma, size=points.shape), normals


@cache
def least_error_of_all_degrees(sigma: float) -> float:
    """Return the least mean distance of the clean points from any fit of the noisy ones."""
    clean, points, normals = noisy(sigma)
    fits = (ipcore.fit_fixed(points, normals, QUICK, degree=n).polynomial for n in range(1, 15))
    return min(float(np.abs(fit.distance(clean)).mean()) for fit in fits)


@pytest.mark.parametrize("criterion", ["gcv", "bic", "loo"])
def test_on_noisy_points_a_criterion_finds_its_minimum_and_tries_some_degrees_more(criterion: str) -> None:
    clean, points, normals = noisy(0.03)
    options = FitOptions.of(criterion=criterion, measure_zero_set=False)
    result = ipcore.fit(points, normals, options)
    assert result.stop_reason is StopReason.CRITERION_MINIMUM
    scores = [getattr(step, criterion) for step in result.steps]
    best = int(np.argmin(scores))
    assert result.degree == result.steps[best].degree == result.steps[-1].degree - DEGREES_PAST_MINIMUM
    assert not any("criterion" in warning.message for warning in result.warnings)
    # it is close to the best that any degree could do, seen from the clean points
    assert np.abs(result.polynomial.distance(clean)).mean() < 2.0 * least_error_of_all_degrees(0.03)


def test_only_the_value_of_the_criterion_is_computed_beside_gcv() -> None:
    _, points, normals = noisy(0.03)
    for criterion in ("distance", "gcv", "bic", "loo"):
        options = FitOptions.of(criterion=criterion, geometric=False, max_degree=3, measure_zero_set=False)
        step = ipcore.fit(points, normals, options).steps[-1]
        assert (step.bic is not None) == (criterion == "bic")
        assert (step.loo is not None) == (criterion == "loo")


def test_without_a_criterion_the_last_degree_is_the_answer() -> None:
    points, normals = shapes.ellipse().sample(300)
    result = ipcore.fit(points, normals, FitOptions.of(criterion="none", max_degree=5, measure_zero_set=False))
    assert result.stop_reason is StopReason.DEGREE_REACHED
    assert result.degree == 5
    assert len(result.steps) == 5
    assert result.diagnostics.d_dist == pytest.approx(result.steps[-1].d_dist, rel=1e-6)


def test_a_search_without_a_number_of_columns_is_an_error() -> None:
    options = FitOptions()
    data = OrientedPoints.of(check_points(*shapes.circle().sample(20)), 12)
    search = DegreeSearch(data, options, choose_linear_fitter(data, options, 1), stopping_criterion(options))
    with pytest.raises(ValueError, match="at least one number of columns"):
        search.run([], None)


def test_another_method_of_fitting_can_be_plugged_in() -> None:
    points, normals = shapes.ellipse().sample(200)
    data = OrientedPoints.of(check_points(points, normals), 12)

    class Halved:
        """Fits linearly, and returns f/2, which has the same zero set."""

        def __init__(self) -> None:
            self._linear = choose_linear_fitter(data, FitOptions(), 4)

        def raise_to(self, alpha: int) -> PrefixFit:
            step = self._linear.raise_to(alpha)
            assert step is not None
            return replace(step, polynomial=replace(step.polynomial, coefficients=step.polynomial.coefficients / 2.0))

        def orthogonality_loss(self, columns: int) -> float | None:
            return self._linear.orthogonality_loss(columns)

    best, reason = DegreeSearch(data, FitOptions(), Halved(), stopping_criterion(FitOptions())).run(
        [3, 6, 10, 15], None
    )
    assert (best.step.degree, reason) == (2, StopReason.CRITERION_MET)
    whole = ipcore.fit_fixed(points, normals, QUICK, degree=2, method="3l").polynomial
    np.testing.assert_allclose(2.0 * best.fit.polynomial(data.points), whole(points), atol=1e-13)


@pytest.mark.parametrize("family", [Constraints.THREE_LAYER, Constraints.TAUBIN])
def test_when_every_column_counts_as_collinear_nothing_is_fitted(family: Constraints) -> None:
    points, normals = shapes.circle().sample(30)
    options = FitOptions.of(
        constraints=family, collinear_tol=1.0, max_degree=3, geometric=False, measure_zero_set=False
    )
    result = ipcore.fit(points, normals, options)
    assert result.stop_reason is StopReason.MAX_DEGREE
    assert result.steps[-1].dropped >= 9


def test_column_counts_are_those_of_complete_forms_or_all() -> None:
    assert list(column_counts(3, 4, ipcore.Granularity.FORM)) == [4, 10, 20, 35]
    assert list(column_counts(3, 2, ipcore.Granularity.MONOMIAL)) == list(range(2, 11))
    assert [graded.degree_of(3, alpha) for alpha in (1, 4, 5, 10, 11)] == [0, 1, 2, 2, 3]


def test_the_lowest_column_is_tried_even_with_few_points_and_then_no_more() -> None:
    points, normals = shapes.circle().sample(12)
    options = FitOptions.of(granularity="monomial", t1=0.0, measure_zero_set=False)
    result = ipcore.fit(points, normals, options)
    assert result.stop_reason is StopReason.TOO_FEW_POINTS
    assert result.steps[-1].alpha == 13  # 12 points determine 13 coefficients up to a factor


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_points_on_a_plane_end_at_degree_one(preset: str) -> None:
    flat = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3)) * [1.0, 1.0, 0.0]
    result = ipcore.fit(flat, np.tile([0.0, 0.0, 1.0], (60, 1)), FitOptions.of(preset, measure_zero_set=False))
    assert result.stop_reason is StopReason.PLANAR
    assert result.degree == 1
    assert np.abs(result.polynomial.distance(flat)).max() < 1e-9


def test_the_result_says_whether_the_zero_set_is_bounded() -> None:
    ellipse = ipcore.fit(*shapes.ellipse().sample(300), QUICK)
    assert ellipse.diagnostics.bounded is True
    cubic = ipcore.fit(*shapes.cubic().sample(300), FitOptions(measure_zero_set=False, t1=1e-9, max_degree=3))
    assert cubic.diagnostics.bounded is False


def steps_without_time(result: ipcore.FitResult) -> list[ipcore.Step]:
    return [replace(step, seconds=0.0) for step in result.steps]


def test_measuring_all_degrees_in_one_pass_changes_nothing() -> None:
    points, normals = shapes.superellipse().sample(300)
    options = FitOptions.of(criterion="none", max_degree=6, geometric=False, measure_zero_set=False)
    together = ipcore.fit(points, normals, options)
    one_by_one = ipcore.fit(points, normals, options, progress=lambda _: None)
    assert [step.degree for step in together.steps] == [1, 2, 3, 4, 5, 6]
    for one, other in zip(steps_without_time(together), steps_without_time(one_by_one), strict=True):
        assert one.d_dist == pytest.approx(other.d_dist, rel=1e-12)
        assert replace(one, d_dist=0.0, d_smooth=0.0) == replace(other, d_dist=0.0, d_smooth=0.0)


class Undetermined:
    """Fits linearly up to some number of columns."""

    def __init__(self, data: OrientedPoints, options: FitOptions, most: int) -> None:
        self._fitter, self._most = choose_linear_fitter(data, options, 6), most

    def raise_to(self, alpha: int) -> PrefixFit | None:
        return self._fitter.raise_to(alpha) if alpha <= self._most else None

    def orthogonality_loss(self, columns: int) -> float | None:
        return self._fitter.orthogonality_loss(columns)


@pytest.mark.parametrize("criterion", ["distance", "none"])
def test_columns_that_are_not_determined_end_the_search_with_the_best_fit_before_them(criterion: str) -> None:
    points, normals = shapes.superellipse().sample(200)
    data = OrientedPoints.of(check_points(points, normals), 12)
    options = FitOptions.of(criterion=criterion, geometric=False, t1=0.0)
    search = DegreeSearch(data, options, Undetermined(data, options, 10), stopping_criterion(options))
    best, reason = search.run([3, 6, 10, 15, 21], None)
    assert reason is StopReason.ILL_CONDITIONED
    assert [step.degree for step in search.steps] == [1, 2, 3]
    expected = search.steps[-1] if criterion == "none" else min(search.steps, key=lambda step: step.d_dist)
    assert best.step == expected


def test_points_on_a_plane_are_planar_whatever_the_criterion() -> None:
    flat = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3)) * [1.0, 1.0, 0.0]
    options = FitOptions.of(criterion="bic", measure_zero_set=False)
    result = ipcore.fit(flat, np.tile([0.0, 0.0, 1.0], (60, 1)), options)
    assert result.stop_reason is StopReason.PLANAR
    assert result.steps[0].bic is not None


class Indifferent(LastDegree):
    """Takes all fits to be equally good."""

    def score(self, step: ipcore.Step) -> float:  # noqa: ARG002 - that is the point
        return 0.0


def test_of_fits_that_are_equally_good_the_lowest_degree_is_returned() -> None:
    data = OrientedPoints.of(check_points(*shapes.superellipse().sample(100)), 12)
    options = FitOptions.of(geometric=False)
    criterion = Indifferent(stopping_criterion(options).rule)
    best, _ = DegreeSearch(data, options, choose_linear_fitter(data, options, 4), criterion).run([3, 6, 10, 15], None)
    assert best.step.degree == 1


def test_the_time_of_measuring_several_fits_at_once_is_shared_among_them(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = count()
    monkeypatch.setattr(degree_search, "perf_counter", lambda: float(next(ticks)))
    points, normals = shapes.superellipse().sample(100)
    options = FitOptions.of(criterion="none", max_degree=4, geometric=False, measure_zero_set=False)
    steps = ipcore.fit(points, normals, options).steps
    assert [step.seconds for step in steps] == [1.25] * 4  # a tick for each fit, and a quarter of one for the pass
