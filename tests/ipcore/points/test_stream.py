"""Points on disk: the same fits as of points that are held."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, shapes
from ipcore._typing import FloatArray
from ipcore.errors import InvalidNormalsError, InvalidPointsError
from ipcore.points import stream

OPTIONS = FitOptions.of(geometric=False, max_degree=6)
MANY = 20_000


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream, "STREAMED_POINTS", 1000)


def rough(count: int = MANY) -> tuple[FloatArray, FloatArray]:
    points, normals = shapes.genus_two().sample(count)
    return points + np.random.default_rng(0).normal(scale=0.01, size=points.shape), normals


def mapped(folder: Path, points: FloatArray, normals: FloatArray) -> tuple[np.ndarray, np.ndarray]:
    np.save(folder / "table.npy", np.hstack([points, normals]))
    table = np.load(folder / "table.npy", mmap_mode="r")
    return table[:, :3], table[:, 3:]


def chunks(points: FloatArray, normals: FloatArray, size: int = 3000) -> Iterator[tuple[FloatArray, FloatArray]]:
    for start in range(0, len(points), size):
        yield points[start : start + size], normals[start : start + size]


@pytest.mark.parametrize("way", ["mapped", "iterator"])
def test_a_stream_is_fitted_as_the_points_are(way: str, tmp_path: Path) -> None:
    points, normals = rough()
    held = ipcore.fit(points, normals, OPTIONS)
    if way == "mapped":
        streamed = ipcore.fit(*mapped(tmp_path, points, normals), OPTIONS)
    else:
        streamed = ipcore.fit(chunks(points, normals), None, OPTIONS)
    assert streamed.degree == held.degree
    assert streamed.input_sha256 == held.input_sha256
    np.testing.assert_allclose(streamed.polynomial(points), held.polynomial(points), atol=1e-10)
    np.testing.assert_allclose(streamed.polynomial.bounds, held.polynomial.bounds, atol=1e-12)
    for one, other in zip(streamed.steps, held.steps, strict=True):
        assert (one.d_dist, one.d_smooth) == pytest.approx((other.d_dist, other.d_smooth), rel=1e-8)
    a, b = streamed.diagnostics, held.diagnostics
    assert (a.d_dist, a.distance_max) == pytest.approx((b.d_dist, b.distance_max), rel=1e-8)
    assert a.distance_p95 == pytest.approx(b.distance_p95, rel=0.05)
    assert a.components == b.components


def test_the_default_fit_of_a_stream_is_that_of_a_sample_measured_at_all_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ipcore.points.sample.SAMPLE_SIZE", 2000)
    points, normals = shapes.torus().sample(5000)
    on_disk = mapped(tmp_path, points, normals)
    read = stream.streamed(*on_disk)
    assert read is not None
    assert len(read.sample.points) == 2000
    result = ipcore.fit(*on_disk)
    assert result.stop_reason is ipcore.StopReason.CRITERION_MET
    assert result.degree <= 4
    at = np.abs(result.polynomial.distance(points)) / result.polynomial.frame.scale
    assert result.diagnostics.d_dist == pytest.approx(at.mean(), rel=1e-6)
    assert result.diagnostics.distance_max == pytest.approx(at.max(), rel=1e-6)


def test_a_small_mapped_array_and_one_without_normals_are_held(tmp_path: Path) -> None:
    points, normals = mapped(tmp_path, *rough(900))
    assert stream.streamed(points, normals) is None
    points, normals = mapped(tmp_path, *rough(1100))
    assert stream.streamed(points, None) is None
    assert stream.streamed(np.array(points), normals) is None
    assert stream.streamed(points, normals) is not None


def test_errors_name_the_row(tmp_path: Path) -> None:
    points, normals = rough(12_000)
    points[9000, 1] = np.nan
    with pytest.raises(InvalidPointsError, match="row 9000, column 1 is nan") as raised:
        ipcore.fit(*mapped(tmp_path, points, normals), OPTIONS)
    assert raised.value.at == ("points", 9000, 1)
    points, normals = rough(12_000)
    normals[10_000] = 0.0
    with pytest.raises(InvalidNormalsError, match="row 10000"):
        ipcore.fit(*mapped(tmp_path, points, normals), OPTIONS)


def test_streams_that_cannot_be_fitted_are_refused(tmp_path: Path) -> None:
    points, normals = rough(2000)
    on_disk = mapped(tmp_path, points, normals)
    with pytest.raises(InvalidNormalsError, match="must match"):
        ipcore.fit(on_disk[0], on_disk[1][:-1], OPTIONS)
    with pytest.raises(InvalidPointsError, match="all points are equal"):
        ipcore.fit(*mapped(tmp_path, np.ones_like(points), normals), OPTIONS)
    with pytest.raises(InvalidPointsError, match="on one line"):
        ipcore.fit(*mapped(tmp_path, points[:, :1] * np.ones(3), normals), OPTIONS)
    with pytest.raises(InvalidPointsError, match="yields no points"):
        ipcore.fit(iter([]), None, OPTIONS)
    with pytest.raises(InvalidNormalsError, match="pairs of points and normals"):
        ipcore.fit(iter([points]), None, OPTIONS)
    with pytest.raises(InvalidNormalsError, match="none go beside it"):
        ipcore.fit(chunks(points, normals), normals, OPTIONS)
    with pytest.raises(InvalidPointsError, match="3 and 2 columns"):
        ipcore.fit(iter([(points, normals), (points[:, :2], normals[:, :2])]), None, OPTIONS)


def test_points_on_a_plane_are_recognised(tmp_path: Path) -> None:
    points = np.random.default_rng(0).uniform(size=(2000, 3)) * [1.0, 1.0, 0.0]
    normals = np.tile([0.0, 0.0, 1.0], (2000, 1))
    result = ipcore.fit(*mapped(tmp_path, points, normals), OPTIONS)
    assert result.stop_reason is ipcore.StopReason.PLANAR
