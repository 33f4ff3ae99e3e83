"""Bernstein coefficients on blocks against exact ones, and the bounds that they give against values."""

from dataclasses import replace
from fractions import Fraction
from itertools import product
from math import comb

import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.proof.blocks import BOX_GROWTH, Blocks, halving, rounding


def polynomial(
    dimension: int, degree: int, seed: int, basis: Basis = Basis.MONOMIAL, half: float = 1.4
) -> ImplicitPolynomial:
    a = np.random.default_rng(seed).normal(size=graded.count(dimension, degree))
    bounds = np.array([[-half] * dimension, [0.9 * half] * dimension])
    return ImplicitPolynomial(degree, a, Frame(np.zeros(dimension), 1.0), bounds, basis)


def exact(p: ImplicitPolynomial, low: list[Fraction], high: list[Fraction]) -> FloatArray:
    """Return the Bernstein coefficients on a block in rational arithmetic, from Σ C(j, i)/C(n, i) of its powers."""
    n, d = p.degree, p.dimension
    shifted: dict[tuple[int, ...], Fraction] = {}
    for powers, a in zip(p.exponents.tolist(), p.coefficients.tolist(), strict=True):
        for some in product(*(range(k + 1) for k in powers)):
            term = Fraction(a)
            for axis, (k, i) in enumerate(zip(powers, some, strict=True)):
                x, y = low[axis], high[axis]
                term *= comb(k, i) * x ** (k - i) * (y - x) ** i
            shifted[some] = shifted.get(some, Fraction(0)) + term
    out = np.empty((n + 1,) * d)
    for j in product(range(n + 1), repeat=d):
        total = Fraction(0)
        for some, value in shifted.items():
            weight = Fraction(1)
            for one, other in zip(j, some, strict=True):
                weight *= Fraction(comb(one, other), comb(n, other))
            total += weight * value
        out[j] = float(total)
    return out


def corner(blocks: Blocks, at: int, upper: int) -> list[Fraction]:
    parts, size = 2**blocks.halvings, blocks.size
    return [
        Fraction(low) + Fraction(step * parts) * (Fraction(place) + upper) / parts
        for low, step, place in zip(blocks.lower.tolist(), size.tolist(), blocks.place[at].tolist(), strict=True)
    ]


@pytest.mark.parametrize(("dimension", "degree", "half"), [(2, 1, 1.0), (2, 6, 1.4), (2, 9, 3.0), (3, 4, 1.5)])
def test_coefficients_are_exact_within_the_slack(dimension: int, degree: int, half: float) -> None:
    p = polynomial(dimension, degree, degree, half=half)
    blocks = Blocks.of(p, 3)
    for _ in range(3):
        for at in range(0, len(blocks), max(1, len(blocks) // 4)):
            truth = exact(p, corner(blocks, at, 0), corner(blocks, at, 1))
            error = np.abs(blocks.coefficients[at] - truth).max()
            assert error <= blocks.slack[at] + 4e-16 * np.abs(truth).max()  # of the block's corners, as read here
            assert blocks.slack[at] < 1e-11 * max(1.0, half) ** degree
        blocks = blocks.halved()
        assert len(blocks)


@pytest.mark.parametrize("basis", list(Basis))
@pytest.mark.parametrize(("dimension", "degree"), [(2, 5), (2, 20), (3, 7)])
def test_values_and_slopes_lie_within_the_bounds(basis: Basis, dimension: int, degree: int) -> None:
    p = polynomial(dimension, degree, 7 * degree, basis, 1.0)
    blocks = Blocks.of(p, 4).halved()
    x = blocks.middle + np.random.default_rng(0).uniform(-0.5, 0.5, blocks.place.shape) * blocks.size
    x = np.clip(x, *p.bounds)
    rows = blocks.coefficients.reshape(len(blocks), -1)
    f, gradient = p.value_and_gradient(x)
    assert (f >= rows.min(axis=1) - blocks.slack).all()
    assert (f <= rows.max(axis=1) + blocks.slack).all()
    low, high = blocks.slopes()
    assert (gradient >= low - 1e-9 * np.abs(gradient)).all()
    assert (gradient <= high + 1e-9 * np.abs(gradient)).all()
    assert ((high - low).max(axis=1) < 60.0 * np.abs(rows).max(axis=1) / blocks.size.min()).all()


def test_the_first_blocks_cover_a_little_more_than_the_bounds() -> None:
    p = polynomial(2, 3, 1)
    blocks = Blocks.of(p, 5)
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
    assert not Blocks.of(p, 4).halved().may_vanish().any()  # f ≥ ¼
    zero = ImplicitPolynomial(2, np.zeros(6), p.frame, p.bounds)
    blocks = Blocks.of(zero, 2)
    places = blocks.halved().place
    assert sorted(map(tuple, places.tolist())) == sorted(product((0.0, 1.0, 2.0, 3.0), repeat=2))
    assert blocks.halved().halvings == 1
    assert blocks.halved().touch_walls().sum() == 12
    assert [half.tolist() for half in halving(2)] == [
        [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.25, 0.5, 0.25]],
        [[0.25, 0.5, 0.25], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]],
    ]


def test_slack_grows_with_every_halving() -> None:
    p = polynomial(2, 8, 3)
    blocks = Blocks.of(p, 2)
    least = blocks.slack.min()
    for _ in range(3):
        blocks = blocks.halved()
        assert blocks.slack.min() > least
        least = blocks.slack.min()


def test_a_zero_at_the_edge_of_rounding_may_be_one() -> None:
    p = polynomial(2, 8, 3)
    blocks = Blocks.of(p, 2)
    lowest = blocks[blocks.coefficients.min(axis=(1, 2)) == blocks.coefficients.min()]
    for height, may in ((0.5, True), (1.5, False)):
        above = lowest.coefficients - lowest.coefficients.min() + height * lowest.slack[:, None, None]
        for shifted in (replace(lowest, coefficients=above), replace(lowest, coefficients=-above)):
            assert shifted.may_vanish().tolist() == [may]
            assert shifted.vanish().tolist() == [False]


@pytest.mark.parametrize("basis", list(Basis))
def test_rounding_bounds_the_error_of_values(basis: Basis) -> None:
    p = polynomial(3, 9, 5, basis, 1.0)
    x = np.random.default_rng(1).uniform(-0.9, 0.9, (50, 3))
    wide = ImplicitPolynomial(9, p.coefficients, p.frame, p.bounds, basis)
    tables = [table.astype(np.longdouble) for table in wide.tables(list(x.T))]
    truth = np.einsum("ijk,mi,mj,mk->m", p.tensor.astype(np.longdouble), *tables)
    error = np.abs(p(x) - truth.astype(float))
    assert (error <= rounding(p, x)).all()
    assert (rounding(p, x) < 1e-9).all()
