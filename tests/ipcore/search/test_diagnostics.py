from dataclasses import replace

import numpy as np
import pytest

from ipcore import FitOptions, shapes
from ipcore.fitting import choose_linear_fitter
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check
from ipcore.search.closeness import closeness
from ipcore.search.criteria import stopping_criterion
from ipcore.search.degree_search import Candidate, DegreeSearch
from ipcore.search.diagnostics import diagnose

OPTIONS = FitOptions.of(geometric=False, criterion="none", measure_zero_set=False)


def candidate() -> tuple[OrientedPoints, Candidate]:
    """Return points beside a superellipse, and a fit of degree 2."""
    points, normals = shapes.superellipse().sample(200)
    data = OrientedPoints.of(
        check(points + np.random.default_rng(0).normal(scale=0.02, size=points.shape), normals), 12
    )
    fitter = choose_linear_fitter(data, OPTIONS, 2)
    return data, DegreeSearch(data, OPTIONS, fitter, stopping_criterion(OPTIONS)).run([6], None)[0]


def good_candidate() -> tuple[OrientedPoints, Candidate]:
    """Return points on an ellipse, and their fit of degree 2."""
    data = OrientedPoints.of(check(*shapes.ellipse().sample(400)), 12)
    fitter = choose_linear_fitter(data, OPTIONS, 2)
    return data, DegreeSearch(data, OPTIONS, fitter, stopping_criterion(OPTIONS)).run([6], None)[0]


@pytest.mark.parametrize("converted", [False, True])
def test_distances_are_those_of_the_delivered_polynomial_over_all_points(*, converted: bool) -> None:
    data, best = candidate()
    f = best.fit.polynomial
    delivered = f.to_chebyshev() if converted else f
    found, _ = diagnose(best, delivered, data, OPTIONS, None)
    distances = np.abs(f.distance(data.points))
    assert found.d_dist == pytest.approx(distances.mean(), rel=1e-9)
    assert found.distance_p95 == pytest.approx(np.quantile(distances, 0.95), rel=1e-9)
    assert found.distance_max == pytest.approx(distances.max(), rel=1e-9)
    assert found.bounded is True
    assert (found.stray, found.components, found.quiet, found.outliers) == (None, None, None, None)


def test_points_without_weight_are_the_outliers_and_do_not_count() -> None:
    data, best = candidate()
    weights = np.where(np.arange(200) < 30, 0.0, 1.0)
    f = best.fit.polynomial
    robust = replace(best, fit=replace(best.fit, weights=weights))
    found, _ = diagnose(robust, f.to_chebyshev(), data, replace(OPTIONS, geometric=True, robust=True), None)
    assert found.outliers == 0.15
    before, _ = diagnose(robust, f, replace(data, outliers=50), replace(OPTIONS, geometric=True, robust=True), None)
    assert before.outliers == (30 + 50) / (200 + 50)
    assert found.d_dist == pytest.approx(np.abs(f.distance(data.points[30:])).mean(), rel=1e-9)
    assert found.d_dist == pytest.approx(closeness(f, data, weights).d_dist, rel=1e-9)


@pytest.mark.parametrize(
    ("seen", "measured", "moved", "quiet"),
    [
        (True, True, 0.0, True),
        (True, False, 0.0, None),  # nothing was looked at: nothing is said
        (False, True, 0.0, False),
        (None, True, 0.0, False),
        (True, True, 1.0, False),  # the points are elsewhere
    ],
)
def test_with_sign_constraints_only_what_is_proved_is_quiet(
    *, seen: bool | None, measured: bool, moved: float, quiet: bool | None
) -> None:
    data, best = good_candidate()
    fitted = replace(best, fit=replace(best.fit, quiet=seen, unsure=0.2))
    elsewhere = replace(data, points=data.points * np.exp(moved))
    options = FitOptions(measure_zero_set=measured)
    found, proof = diagnose(fitted, best.fit.polynomial, elsewhere, options, 0.5)
    assert found.quiet is quiet
    assert (found.unsure, found.orthogonality_loss) == (0.2, 0.5)
    assert (proof is None) == (not measured)
    if proof is not None:
        assert proof.holds == (moved == 0.0)
        assert bool(proof.uncleared) == bool(moved)


def test_what_is_proved_is_not_measured() -> None:
    data, best = good_candidate()
    found, proof = diagnose(best, best.fit.polynomial, data, FitOptions(), None)
    assert proof is not None
    assert (proof.components, proof.euler) == (1, 0)
    assert (found.stray, found.components) == (0.0, 1)


def test_a_linear_fit_that_is_seen_to_stray_is_not_to_be_proved() -> None:
    data, best = good_candidate()
    options = replace(OPTIONS, measure_zero_set=True)
    found, proof = diagnose(best, best.fit.polynomial, replace(data, points=2.0 * data.points), options, None)
    assert found.stray
    assert proof is None
    near, proved = diagnose(best, best.fit.polynomial, data, options, None)
    assert near.stray == 0.0
    assert near.quiet is None
    assert proved is not None
    assert proved.holds
