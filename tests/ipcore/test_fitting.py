from collections.abc import Callable

import numpy as np
import pytest
from skimage import data, measure

import ipcore
from ipcore import shapes
from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.search.criteria import stopping_criterion
from ipcore.shapes import Shape

EPS = np.finfo(float).eps
# Where three layers stop below the shape's own degree, they are close and smooth enough there by eq. (7): the sextic
# superellipsoid is within 0.0063 mean radii of a quartic.
OWN_DEGREE = {shape: shape().polynomial.degree for shape in (*shapes.CURVES, *shapes.SURFACES)}
OWN_DEGREE[shapes.superellipsoid] = 4


def outline(image: FloatArray, level: float) -> FloatArray:
    return np.asarray(max(measure.find_contours(image, level), key=len))


def sampled(make: Callable[[], Shape], count: int = 300) -> tuple[FloatArray, FloatArray]:
    return make().sample(count if make().polynomial.dimension == 2 else 4 * count)


@pytest.mark.parametrize("make", OWN_DEGREE)
def test_a_noise_free_shape_stops_at_its_own_degree(make: Callable[[], Shape]) -> None:
    result = ipcore.fit(*sampled(make))
    assert result.degree == OWN_DEGREE[make]
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    assert [step.degree for step in result.steps] == list(range(1, result.degree + 1))
    assert result.diagnostics.d_dist < 0.01
    assert result.diagnostics.d_smooth > 0.95


@pytest.mark.parametrize("make", OWN_DEGREE)
def test_a_fit_is_the_same_after_a_rigid_motion_and_a_change_of_scale(make: Callable[[], Shape]) -> None:
    points, normals = sampled(make)
    d = points.shape[1]
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(d, d)))[0]  # a rigid motion, mirrored or not
    linear = ipcore.FitOptions(geometric=False)  # signs are asked for on a grid along the axes
    plain = ipcore.fit(points, normals, linear)
    moved = ipcore.fit(37.0 * points @ rotation.T + 1000.0, normals @ rotation.T, linear)
    assert moved.degree == plain.degree
    # both solve the same least-squares problem, so they differ by rounding times the condition they report; the shift
    # alone costs the data themselves eps · 1000/37
    tolerance = 1000.0 * EPS * (plain.steps[-1].condition + 1000.0)
    for one, other in zip(plain.steps, moved.steps, strict=True):
        assert abs(one.d_dist - other.d_dist) < tolerance
        assert abs(one.d_smooth - other.d_smooth) < tolerance
    x = points + 0.02 * normals
    expected, scale = plain.polynomial(x), np.abs(plain.polynomial(x)).max()
    np.testing.assert_allclose(moved.polynomial(37.0 * x @ rotation.T + 1000.0), expected, atol=tolerance * scale * 10)


def test_the_cell_and_the_horse_of_scikit_image() -> None:
    cell = ipcore.fit(outline(data.cell().astype(float), 110.0))
    assert 2 <= cell.degree <= 4
    assert cell.stop_reason is ipcore.StopReason.CRITERION_MET
    assert cell.diagnostics.normal_source is ipcore.NormalSource.OUTLINE
    horse = ipcore.fit(outline((~data.horse()).astype(float), 0.5), options=ipcore.FitOptions(max_degree=12))
    assert horse.stop_reason is ipcore.StopReason.MAX_DEGREE
    assert any("max_degree" in warning.message for warning in horse.warnings)
    assert cell.diagnostics.d_dist < 0.01 < horse.diagnostics.d_dist
    best = min(horse.steps, key=lambda step: max(step.d_dist / 0.01, (1 - step.d_smooth) / 0.05))
    assert horse.degree == best.degree


def test_coefficients_vanish_on_the_input_by_the_contracts_sentence_alone() -> None:
    points, normals = shapes.torus().sample(1000)
    for scale, shift in ((1.0, 0.0), (37.0, 1000.0)):
        x = scale * points + shift
        answer = ipcore.fit(x, normals).to_dict()["polynomial"]
        centre, unit = np.array(answer["frame"]["centre"]), answer["frame"]["scale"]
        terms = (((x - centre) / unit)[:, None, :] ** np.array(answer["exponents"])).prod(axis=2)
        f = terms @ np.array(answer["coefficients"])
        assert np.abs(f).mean() < 0.01  # f is about the distance, in mean radii
        on_the_core = (([shift + scale, shift, shift] - centre) / unit) ** np.array(answer["exponents"])
        assert on_the_core.prod(axis=1) @ np.array(answer["coefficients"]) < 0.0


def test_noise_that_never_meets_the_rule_still_gives_the_best_fit_and_its_reason() -> None:
    points, normals = shapes.ellipse().sample(400)
    noisy = points + np.random.default_rng(0).normal(scale=0.05, size=points.shape)
    options = ipcore.FitOptions(max_degree=8)
    result = ipcore.fit(noisy, normals, options)
    assert result.stop_reason is ipcore.StopReason.MAX_DEGREE
    assert len(result.steps) == 8
    best = min(result.steps, key=stopping_criterion(options).score)  # not always the closest: a quiet one comes first
    assert result.diagnostics.d_dist == pytest.approx(best.d_dist, rel=1e-6)


def test_more_coefficients_than_points_are_not_tried() -> None:
    points, normals = shapes.circle().sample(12)
    result = ipcore.fit(points, normals, ipcore.FitOptions(t1=0.0))
    assert result.stop_reason is ipcore.StopReason.TOO_FEW_POINTS
    assert result.steps[-1].degree == 3  # 10 coefficients; degree 4 has 15


def test_points_on_a_plane_are_fitted_by_degree_one_with_a_warning() -> None:
    generator = np.random.default_rng(0)
    plane = (
        np.column_stack([generator.uniform(-1, 1, (60, 2)), np.zeros(60)])
        @ np.linalg.qr(generator.normal(size=(3, 3)))[0]
    )
    result = ipcore.fit(plane + 5.0)
    assert result.degree == 1
    assert np.abs(result.polynomial.distance(plane + 5.0)).max() < 1e-13
    stubborn = ipcore.fit(plane, options=ipcore.FitOptions(t1=0.0))
    assert stubborn.stop_reason is ipcore.StopReason.PLANAR
    assert any("plane" in warning.message for warning in stubborn.warnings)


def test_progress_sees_every_step_and_may_stop_the_fit() -> None:
    points, normals = shapes.torus().sample(500)
    seen: list[ipcore.Step] = []
    result = ipcore.fit(points, normals, progress=seen.append)
    assert tuple(seen) == result.steps

    class EnoughError(Exception):
        pass

    def stop(step: ipcore.Step) -> None:
        if step.degree == 2:
            raise EnoughError

    with pytest.raises(EnoughError):
        ipcore.fit(points, normals, progress=stop)


def test_the_same_input_gives_the_same_answer() -> None:
    points, normals = shapes.genus_two().sample(600)
    one, other = ipcore.fit(points, normals), ipcore.fit(points, normals)
    np.testing.assert_array_equal(one.polynomial.coefficients, other.polynomial.coefficients)
    assert one.input_sha256 == other.input_sha256 != ipcore.fit(points[::-1], normals[::-1]).input_sha256


def test_the_chebyshev_basis_is_the_same_polynomial() -> None:
    points, normals = shapes.genus_two().sample(600)
    powers = ipcore.fit(points, normals).polynomial
    products = ipcore.fit(points, normals, ipcore.FitOptions(basis=ipcore.Basis.CHEBYSHEV)).polynomial
    assert (powers.basis, products.basis) == (ipcore.Basis.MONOMIAL, ipcore.Basis.CHEBYSHEV)
    np.testing.assert_allclose(powers(points), products(points), atol=1e-12)
    assert len(powers.coefficients) == graded.count(3, powers.degree)


def test_bounds_are_the_datas_box_grown_by_three_tenths_of_the_mean_radius() -> None:
    points, normals = shapes.ellipsoid().sample(500)
    bounds = ipcore.fit(points, normals).polynomial.bounds
    margin = 0.3 * Frame.of(points).scale
    np.testing.assert_allclose(bounds, [points.min(axis=0) - margin, points.max(axis=0) + margin], rtol=1e-12)


TWO = ipcore.FitOptions(max_degree=2)


def test_wrongly_oriented_normals_are_noticed() -> None:
    points, normals = shapes.sphere().sample(500)
    inward = ipcore.fit(points, -normals, TWO)
    assert inward.diagnostics.normal_self_check < 0.1
    assert [warning.code for warning in inward.warnings] == ["normals-inward"]
    mixed = ipcore.fit(points, np.where(np.arange(500)[:, None] % 5 == 0, -normals, normals), TWO)
    assert "normals-doubtful" in [warning.code for warning in mixed.warnings]


def test_stray_sheets_are_measured_and_reported() -> None:
    points, normals = shapes.ellipse(3.0, 1.0).sample(2000)
    quiet = ipcore.fit(points, normals).diagnostics
    assert (quiet.stray, quiet.components) == (0.0, 1)
    unmeasured = ipcore.fit(points, normals, ipcore.FitOptions(measure_zero_set=False)).diagnostics
    assert (unmeasured.stray, unmeasured.components) == (None, None)
    wild = ipcore.fit(
        outline((~data.horse()).astype(float), 0.5), options=ipcore.FitOptions(max_degree=12, geometric=False)
    )
    assert wild.diagnostics.stray is not None
    assert wild.diagnostics.stray > 0.05
    assert any("away from all data" in warning.message for warning in wild.warnings)


def test_a_checked_point_set_is_fitted_as_it_is() -> None:
    points, normals = shapes.ellipse().sample(60)
    checked = ipcore.check_points(points, normals)
    fitted, expected = ipcore.fit(checked), ipcore.fit(points, normals)
    assert (fitted.polynomial.coefficients == expected.polynomial.coefficients).all()
    assert fitted.to_dict()["engine"] == expected.to_dict()["engine"]
    with pytest.raises(ipcore.InvalidNormalsError, match="has its own normals"):
        ipcore.fit(checked, normals)
