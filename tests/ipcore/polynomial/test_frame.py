import numpy as np

from ipcore.polynomial.frame import Frame


def test_local_points_have_centroid_zero_and_mean_radius_one() -> None:
    x = np.random.default_rng(0).normal(3.0, 20.0, (50, 3))
    local = Frame.of(x).to_local(x)
    np.testing.assert_allclose(local.mean(axis=0), 0.0, atol=1e-14)
    assert abs(np.linalg.norm(local, axis=1).mean() - 1.0) < 1e-14


def test_there_and_back() -> None:
    x = np.random.default_rng(1).normal(1000.0, 37.0, (50, 2))
    frame = Frame.of(x)
    np.testing.assert_allclose(frame.to_raw(frame.to_local(x)), x, rtol=1e-15)
