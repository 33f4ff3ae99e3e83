import numpy as np
import pytest
from numpy.typing import ArrayLike

from ipcore.errors import InvalidNormalsError, InvalidPointsError
from ipcore.points.validation import check

SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
LINE = np.linspace(0.0, 1.0, 20)


@pytest.mark.parametrize(
    ("points", "says", "at"),
    [
        ([[0, 0], [1, float("nan")], [0, 1]], r"row 1, column 1 is nan \(1 value in all\)", ("points", 1, 1)),
        ([[0, 0], [1, 1], [float("inf"), -float("inf")]], r"row 2, column 0 is inf \(2 values", ("points", 2, 0)),
        (np.zeros(5), "two axes", ("points",)),
        (np.zeros((5, 4)), "2 or 3 columns, not 4", ("points",)),
        (np.zeros((5, 1)), "2 or 3 columns, not 1", ("points",)),
        ([[0, 1], [1, 0]], "2 points are too few: a fit of degree 1 in 2D needs at least 3", ("points",)),
        ([[0, 1, 0], [1, 0, 0], [0, 0, 1]], "3 points are too few", ("points",)),
        (np.zeros((0, 3)), "0 points are too few", ("points",)),
        ([[0, 1], [1]], "array of numbers", ("points",)),
        ([["a", "b"]] * 4, "array of numbers", ("points",)),
        (np.full((9, 3), 7.3), "all points are equal", ("points",)),
        (np.stack([LINE, 3 * LINE + 1], axis=1), "on one line", ("points",)),
        (np.stack([LINE, 3 * LINE + 1, -LINE], axis=1), "on one line", ("points",)),
        ([[0, 0], [1e300, 1], [0, 1e300]], "too large", ("points",)),
    ],
)
def test_points_that_cannot_be_fitted(points: ArrayLike, says: str, at: tuple[str | int, ...]) -> None:
    with pytest.raises(InvalidPointsError, match=says) as caught:
        check(points)
    assert caught.value.at == at


@pytest.mark.parametrize(
    ("normals", "says", "at"),
    [
        (np.ones((3, 2)), "must match", ("normals",)),
        (np.ones((4, 3)), "must match", ("normals",)),
        ([[1, 0], [0, 0], [0, 0], [1, 1]], r"length 0: row 1 has \(2 in all\)", ("normals", 1)),
        ([[1, 0], [0, 1], [np.nan, 0], [1, 1]], "row 2, column 0 is nan", ("normals", 2, 0)),
    ],
)
def test_normals_that_do_not_match(normals: ArrayLike, says: str, at: tuple[str | int, ...]) -> None:
    with pytest.raises(InvalidNormalsError, match=says) as caught:
        check(SQUARE, normals)
    assert caught.value.at == at


def test_a_line_is_one_however_far_off_and_however_stored() -> None:
    slanted = np.stack([LINE, np.pi * LINE, 2 - LINE], axis=1)
    for points in (1e6 + slanted, 1e-9 * slanted, slanted.astype(np.float32)):
        with pytest.raises(InvalidPointsError, match="on one line"):
            check(points)


def test_a_plane_is_told_from_a_thin_slab() -> None:
    generator = np.random.default_rng(0)
    flat = generator.normal(size=(50, 3)) @ np.diag([1.0, 1.0, 0.0]) @ np.linalg.qr(generator.normal(size=(3, 3)))[0]
    assert check(flat).planar
    assert check(flat.astype(np.float32) + np.float32(1.0)).planar
    assert not check(flat + generator.normal(scale=1e-3, size=(50, 3))).planar
    assert not check(SQUARE).planar


@pytest.mark.parametrize("size", [1e-200, 1.0, 1e200])
def test_normals_come_back_with_unit_length(size: float) -> None:
    given = check(SQUARE, size * np.array(SQUARE) + size)
    assert given.normals is not None
    np.testing.assert_allclose(np.linalg.norm(given.normals, axis=1), 1.0, rtol=1e-15)


def test_other_number_types_become_doubles() -> None:
    assert check(np.array(SQUARE, dtype=">i2")).points.dtype == np.float64
