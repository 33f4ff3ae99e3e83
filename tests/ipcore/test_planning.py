"""The plan of a fit: what it tries, holds and takes is known before it runs."""

from math import comb

import numpy as np
import pytest

import ipcore
from ipcore import Constraints, Criterion, Factor, FitOptions


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("family", list(Constraints))
def test_rows_are_those_that_the_family_makes(dimension: int, family: Constraints) -> None:
    options = FitOptions(constraints=family)
    x = np.random.default_rng(0).normal(size=(7, dimension))
    made = options.family.rows(x, x, options.row_parameters).b(1)
    assert ipcore.plan(dimension, 7, options, normals=True).rows == len(made)


@pytest.mark.parametrize(
    ("options", "held"),
    [
        (FitOptions(), False),
        (FitOptions(geometric=False), False),
        (FitOptions(factor=Factor.TSQR), False),
        (FitOptions(factor=Factor.BLOCK), True),
        (FitOptions(criterion=Criterion.LOO), True),
        (FitOptions(constraints=Constraints.TAUBIN), True),
        (FitOptions.of("paper"), True),
    ],
)
def test_a_system_counts_when_it_is_held(options: FitOptions, held: bool) -> None:
    found = ipcore.plan(3, 5000, options, normals=True)
    assert found.held_bytes == (8 * found.rows * comb(16 + 3, 3) if held else 0)


def test_few_points_have_as_many_columns() -> None:
    assert ipcore.plan(3, 100, FitOptions(factor=Factor.BLOCK), normals=True).held_bytes == 8 * 300 * 100


def test_moments_add_only_for_linear_fits_with_normals() -> None:
    linear = FitOptions(geometric=False)
    assert ipcore.plan(3, 100, linear, normals=True).summable
    assert not ipcore.plan(3, 100, linear, normals=False).summable
    assert not ipcore.plan(3, 100, FitOptions(), normals=True).summable


def test_a_degree_that_the_dimension_does_not_allow_is_refused() -> None:
    assert ipcore.plan(2, 100, FitOptions(max_degree=21), normals=True).max_degree == 21
    with pytest.raises(ipcore.InvalidOptionsError, match="at most 20 for 3D"):
        ipcore.plan(3, 100, FitOptions(max_degree=21), normals=True)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("geometric", [False, True])
@pytest.mark.parametrize("normals", [False, True])
def test_more_points_and_higher_degrees_take_longer(dimension: int, geometric: bool, normals: bool) -> None:
    def seconds(points: int, degree: int) -> float:
        options = FitOptions(max_degree=degree, geometric=geometric)
        return ipcore.plan(dimension, points, options, normals=normals).seconds

    by_size = [seconds(1000, 5), seconds(2000, 5), seconds(2000, 10)]
    assert by_size == sorted(by_size)
