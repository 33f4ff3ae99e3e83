from dataclasses import replace

import numpy as np
import pytest

from ipcore import Constraints, FitOptions, fit_fixed, shapes
from ipcore.points.oriented import PART, OrientedPoints
from ipcore.points.stream import PointStream
from ipcore.points.validation import check
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.search.closeness import closeness, closenesses, delivery_shift, distance_quantile, distances_and_cosines

EPS = np.finfo(float).eps


def fits(count: int) -> tuple[OrientedPoints, list[ImplicitPolynomial]]:
    points, normals = shapes.torus().sample(count)
    data = OrientedPoints.of(check(points + 0.01 * np.random.default_rng(0).normal(size=points.shape), normals), 12)
    options = FitOptions(measure_zero_set=False)
    method = Constraints.THREE_LAYER
    return data, [fit_fixed(data.points, data.normals, options, degree=n, method=method).polynomial for n in (2, 5, 3)]


@pytest.mark.parametrize("count", [300, 2 * PART + 100])
def test_several_polynomials_are_seen_in_one_pass(count: int) -> None:
    data, polynomials = fits(count)
    # of one frame, as those of a search are; theirs is the normalised one but for rounding
    polynomials = [
        ImplicitPolynomial(p.degree, p.coefficients, polynomials[0].frame, polynomials[0].bounds) for p in polynomials
    ]
    weights = np.random.default_rng(0).uniform(size=count)
    for w in (None, weights):
        for p, at in zip(polynomials, closenesses(polynomials, data, w), strict=True):
            distances, cosines = distances_and_cosines(*p.value_and_gradient(data.points), data.normals)
            assert at.d_dist == pytest.approx(np.average(distances, weights=w), rel=1e-12)
            assert at.d_smooth == pytest.approx(np.average(cosines, weights=w), rel=1e-12)
            assert at.max_distance == pytest.approx(distances.max(), rel=1e-12)
            assert closeness(p, data, w).d_dist == pytest.approx(at.d_dist, rel=1e-12)
            assert distance_quantile(p, data, 0.95) == pytest.approx(np.quantile(distances, 0.95), rel=1e-12)


def test_what_a_change_of_basis_moves_is_seen_at_the_worst_point() -> None:
    data, polynomials = fits(500)
    p = polynomials[1]
    q = p.to_chebyshev()
    assert delivery_shift(p, p, data) == 0.0
    shift = np.abs(p(data.points) - q(data.points)) / np.linalg.norm(q.gradient(data.points), axis=1)
    assert delivery_shift(p, q, data) == pytest.approx(shift.max(), rel=1e-6, abs=EPS)


def test_points_beside_a_circle_are_as_far_as_they_are() -> None:
    points, normals = shapes.circle().sample(100)
    circle = shapes.circle().polynomial
    distances, cosines = distances_and_cosines(*circle.value_and_gradient(points + 1e-4 * normals), normals)
    assert np.abs(distances - 1e-4).max() < 1e-7  # first order: the error is of second
    assert np.abs(cosines - 1.0).max() < 1e-12
    _, inward = distances_and_cosines(*circle.value_and_gradient(points), -normals)
    assert np.abs(inward + 1.0).max() < 1e-12


def test_a_point_without_gradient_is_far_and_not_undefined() -> None:
    (distance,), (cosine,) = distances_and_cosines(np.array([1.0]), np.zeros((1, 2)), np.array([[1.0, 0.0]]))
    assert distance > 1e300
    assert cosine == 0.0


@pytest.mark.parametrize("shift", [1e-9, 1e-3])
def test_a_circle_delivered_with_another_radius_has_moved_by_the_difference(shift: float) -> None:
    points, normals = shapes.circle().sample(100)
    data = OrientedPoints.of(check(1.1 * points, normals), 12)  # neither f is 0 there
    r = float(np.linalg.norm(data.points, axis=1).mean())  # 1, but for the centroid of a sample
    centred = replace(data, points=data.points / np.linalg.norm(data.points, axis=1, keepdims=True) * r)
    fitted, moved = (
        centred.polynomial(2, np.array([-(radius**2), 0.0, 0.0, 1.0, 0.0, 1.0]), Basis.MONOMIAL)
        for radius in (0.9 * r, 0.9 * r - shift)
    )
    # f moves by 2 (0.9 r) shift − shift² everywhere, and ‖∇f‖ = 2 r
    expected = 0.9 * shift - shift**2 / (2.0 * r)
    assert delivery_shift(fitted, moved.to_chebyshev(), centred) == pytest.approx(expected, rel=1e-6)


def test_of_a_stream_every_point_counts_unless_there_are_weights() -> None:
    angle = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, 60_000)  # a stream holds a sample of 50,000
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    points = normals * np.random.default_rng(1).uniform(0.9, 1.1, (60_000, 1))
    stream = OrientedPoints.of(PointStream.of(points, normals), 12)
    f = stream.polynomial(2, np.array([-1.0, 0.0, 0.0, 1.0, 0.0, 1.0]), Basis.MONOMIAL)
    every = stream.frame.to_local(points)
    distances, _ = distances_and_cosines(*f.value_and_gradient(every), normals)
    assert closeness(f, stream).d_dist == pytest.approx(distances.mean(), rel=1e-10)
    assert closeness(f, stream).max_distance == pytest.approx(distances.max(), rel=1e-10)
    held, _ = distances_and_cosines(*f.value_and_gradient(stream.points), stream.normals)
    weights = np.linspace(0.0, 1.0, len(held))
    assert closeness(f, stream, weights).d_dist == pytest.approx(np.average(held, weights=weights), rel=1e-10)
