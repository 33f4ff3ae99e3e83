"""Coefficients and bounds on blocks against rational arithmetic."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.proof.blocks import LEFT_OUT, Blocks
from ipcore.proof.restriction import BOX_GROWTH, first_blocks, restricted
from ipcore.proof.subdivision import halved
from tests.ipcore.proof.exact import errors, polynomial, univariate, value, variable

KINDS = [
    (2, 1, 1.0, Basis.MONOMIAL),
    (2, 6, 1.4, Basis.MONOMIAL),
    (2, 9, 3.0, Basis.MONOMIAL),
    (2, 12, 1.0, Basis.CHEBYSHEV),
    (3, 5, 1.5, Basis.MONOMIAL),
    (3, 6, 0.7, Basis.CHEBYSHEV),
]


def some_places(dimension: int, count: int) -> list[list[Fraction]]:
    rng = np.random.default_rng(0)
    inner = [[Fraction(int(k), 8) for k in rng.integers(-8, 9, dimension)] for _ in range(count)]
    return [[Fraction(1)] * dimension, [Fraction(-1)] * dimension, *inner]


def assert_within_slack(p: ImplicitPolynomial, blocks: Blocks) -> None:
    for block in range(0, len(blocks), max(1, len(blocks) // 3)):
        for s in some_places(p.dimension, 2):
            error, slope_errors = errors(p, blocks, block, s)
            assert abs(error) <= blocks.slack[block]
            for slope_error, slack in zip(slope_errors, blocks.slope_slack[block], strict=True):
                assert abs(slope_error) <= slack


@pytest.mark.parametrize(("dimension", "degree", "half", "basis"), KINDS)
def test_the_first_coefficients_are_those_of_the_polynomial(
    dimension: int, degree: int, half: float, basis: Basis
) -> None:
    p = polynomial(dimension, degree, degree, basis, half)
    blocks = first_blocks(p, 3)
    assert len(blocks) == 3**dimension
    assert blocks.degree == degree
    assert_within_slack(p, blocks)
    assert blocks.slack.max() < 1e-10 * max(1.0, half) ** degree


@pytest.mark.parametrize(("dimension", "degree", "half", "basis"), KINDS)
def test_halves_differ_by_their_slack_at_most(dimension: int, degree: int, half: float, basis: Basis) -> None:
    p = polynomial(dimension, degree, degree, basis, half)
    blocks = first_blocks(p, 3)
    for halvings in range(1, 4):
        slack = blocks.slack.min()
        blocks = blocks.halved()
        assert len(blocks)
        assert blocks.halvings == halvings
        assert_within_slack(p, blocks)
        assert slack < blocks.slack.min() < 3.0 * slack + 1e-14


@pytest.mark.parametrize(("dimension", "degree", "half", "basis"), KINDS)
def test_what_is_left_out_is_in_the_slack(dimension: int, degree: int, half: float, basis: Basis) -> None:
    p = polynomial(dimension, degree, degree, basis, half)
    blocks = first_blocks(p, 4)
    for kept in range(1, degree):
        few = blocks.up_to(kept)
        assert few.degree == kept
        assert_within_slack(p, few)
        assert (few.slack > blocks.slack).all()
    assert blocks.up_to(degree) is blocks


@pytest.mark.parametrize(("dimension", "degree", "half", "basis"), KINDS[1:])
def test_halved_and_reduced_again_and_again(dimension: int, degree: int, half: float, basis: Basis) -> None:
    p = polynomial(dimension, degree, degree, basis, half)
    blocks = first_blocks(p, 2)
    for _ in range(6):
        blocks = halved(p, blocks[blocks.may_vanish()][:40])
        assert len(blocks)
        assert_within_slack(p, blocks)
        assert not blocks.is_stale().any()
    assert blocks.degree < degree


def test_no_more_than_allowed_is_left_out() -> None:
    p = polynomial(3, 9, 1, Basis.CHEBYSHEV, 1.0)
    blocks = first_blocks(p, 8)
    sizes = np.abs(blocks.coefficients).reshape(-1, len(blocks))
    for share in (1e-1, 1e-3, LEFT_OUT):
        few = blocks.reduced(share)
        assert (few.slack - blocks.slack <= 1.001 * share * sizes[1:].sum(axis=0)).all()
        fewer = blocks.up_to(few.degree - 1)
        assert (fewer.slack - blocks.slack > share * sizes[1:].sum(axis=0)).any()
    assert blocks.reduced(0.0) is blocks


@pytest.mark.parametrize(("dimension", "degree", "half", "basis"), KINDS)
def test_stale_blocks_are_computed_afresh(dimension: int, degree: int, half: float, basis: Basis) -> None:
    p = polynomial(dimension, degree, degree, basis, half)
    blocks = first_blocks(p, 2).halved().halved()
    fresh = restricted(p, replace(blocks, slack=blocks.slack + 1.0))
    assert fresh.degree == degree
    assert (fresh.slack < 1.0).all()
    assert_within_slack(p, fresh)


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize(("dimension", "degree"), [(2, 5), (2, 20), (3, 7)])
def test_values_and_slopes_lie_within_the_bounds(basis: Basis, dimension: int, degree: int) -> None:
    p = polynomial(dimension, degree, 7 * degree, basis, 1.0)
    blocks = first_blocks(p, 4).halved()
    x = blocks.middle + np.random.default_rng(0).uniform(-0.5, 0.5, blocks.place.shape) * blocks.size
    x = np.clip(x, *p.bounds)
    f, gradient = p.value_and_gradient(x)
    assert blocks.may_vanish()[np.abs(f) < 1e-3].all()
    low, high = blocks.slopes()
    assert (gradient >= low - 1e-9 * np.abs(gradient)).all()
    assert (gradient <= high + 1e-9 * np.abs(gradient)).all()
    around = np.abs(gradient).max()
    assert np.median(high - low) < around


def edge(axis: int, dimension: int, upper: bool) -> list[Fraction]:
    return [Fraction(1 if upper else -1) if k == axis else Fraction(0) for k in range(dimension)]


@pytest.mark.parametrize(("dimension", "axis"), [(2, 0), (2, 1), (3, 0), (3, 1), (3, 2)])
def test_bounds_are_sharp_for_polynomials_of_one_variable(dimension: int, axis: int) -> None:
    """x² has the slope 2x, which is bounded at the ends of the block, and vanishes at 0 only."""
    a = np.zeros((3,) * dimension)
    a[tuple(2 if k == axis else 0 for k in range(dimension))] = 1.0
    bounds = np.array([[-1.0] * dimension, [2.0] * dimension])
    exponents = polynomial(dimension, 2, 0).exponents
    p = ImplicitPolynomial(2, a[tuple(exponents.T)], Frame(np.zeros(dimension), 1.0), bounds)
    blocks = first_blocks(p, 3)
    low, high = blocks.slopes()
    for block in range(len(blocks)):
        ends = [
            variable(p, blocks, block, axis, edge(axis, dimension, upper=upper)[axis])[0] for upper in (False, True)
        ]
        np.testing.assert_allclose([low[block, axis], high[block, axis]], [2.0 * float(u) for u in ends], atol=1e-9)
        others = [k for k in range(dimension) if k != axis]
        np.testing.assert_allclose(low[block, others], 0.0, atol=1e-9)
        assert blocks.may_vanish()[block] == (ends[0] <= 1e-9 and ends[1] >= -1e-9)
    assert not blocks.vanish().any()


@pytest.mark.parametrize(("dimension", "corner"), [(2, (0, 0)), (2, (1, 0)), (3, (1, 0, 1)), (3, (0, 1, 1))])
def test_a_zero_is_seen_from_the_signs_at_any_two_corners(dimension: int, corner: tuple[int, ...]) -> None:
    """Of all corners of the box one has another sign."""
    signs = np.array([1.0 if k else -1.0 for k in corner])
    a = np.zeros(1 + dimension)
    a[0], a[1:] = dimension - 0.5, -signs
    bounds = np.array([[-1.0] * dimension, [1.0] * dimension])
    p = ImplicitPolynomial(1, a, Frame(np.zeros(dimension), 1.0), bounds)
    blocks = first_blocks(p, 1)
    assert blocks.vanish().tolist() == [True]
    assert (-signs @ signs + dimension - 0.5) < 0.0
    shifted = replace(p, coefficients=np.concatenate([[dimension + 0.5], -signs]))
    assert first_blocks(shifted, 1).vanish().tolist() == [False]
    assert first_blocks(shifted, 1).may_vanish().tolist() == [False]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_zero_within_the_slack_may_be_one(sign: float) -> None:
    bounds = np.array([[-1.0, -1.0], [1.0, 1.0]])
    p = ImplicitPolynomial(2, np.array([sign, 0.25, 0.125, 0, 0, 0]), Frame(np.zeros(2), 1.0), bounds)
    one = first_blocks(p, 1)
    assert not one.may_vanish().any()
    for slack, may in ((0.624, False), (0.626, True)):
        assert replace(one, slack=np.array([slack])).may_vanish().tolist() == [may]
    both = ImplicitPolynomial(2, np.array([0.0, 0.25, 0.125, 0, 0, 0]), p.frame, bounds)
    for slack, does in ((0.37, True), (0.38, False)):
        assert replace(first_blocks(both, 1), slack=np.array([slack])).vanish().tolist() == [does]


def test_the_first_blocks_cover_a_little_more_than_the_bounds() -> None:
    p = polynomial(2, 3, 1)
    blocks = first_blocks(p, 5)
    upper = blocks.lower + 5 * blocks.size
    length = p.bounds[1] - p.bounds[0]
    assert (blocks.lower < p.bounds[0]).all()
    assert (upper > p.bounds[1]).all()
    np.testing.assert_allclose(blocks.lower, p.bounds[0] - BOX_GROWTH * length, rtol=1e-14)
    np.testing.assert_allclose(blocks.middle.min(axis=0) - blocks.lower, blocks.size / 2, rtol=1e-9)
    assert blocks.radius >= np.linalg.norm(blocks.size) / 2


def test_halves_are_the_whole() -> None:
    bounds = np.array([[-1.0, -1.0], [1.0, 1.0]])
    p = ImplicitPolynomial(2, np.array([0.25, 0, 0, 1, 0, 1]), Frame(np.zeros(2), 1.0), bounds)
    assert not first_blocks(p, 4).halved().may_vanish().any()  # f ≥ ¼
    zero = ImplicitPolynomial(2, np.zeros(6), p.frame, p.bounds)
    blocks = first_blocks(zero, 2).halved()
    assert sorted(map(tuple, blocks.place.tolist())) == sorted(product((0.0, 1.0, 2.0, 3.0), repeat=2))
    assert blocks.halvings == 1
    assert blocks.touch_walls().sum() == 12
    places = np.vstack([chunk.place for chunk in blocks.chunks()])
    np.testing.assert_array_equal(places, blocks.place)
    again = Blocks.together([blocks[:5], blocks[5:]])
    np.testing.assert_array_equal(again.coefficients, blocks.coefficients)
    assert len(again.without_coefficients()) == len(again)
    assert again.without_coefficients().coefficients.size == 0


def test_exact_arithmetic_is_right() -> None:
    values, slopes = univariate(Basis.CHEBYSHEV, 3, Fraction(1, 2))
    assert [float(one) for one in values] == [1.0, 0.5, -0.5, -1.0]
    assert [float(one) for one in slopes] == [0.0, 1.0, 2.0, 0.0]
    values, slopes = univariate(Basis.MONOMIAL, 3, Fraction(1, 2))
    assert (values[3], slopes[3]) == (Fraction(1, 8), Fraction(3, 4))
    assert value(np.array([[1.0, 2.0], [3.0, 4.0]]), [[Fraction(1), Fraction(5)], [Fraction(1), Fraction(7)]]) == 170
