import numpy as np
import pytest

from ipcore.polynomial import graded

TABLE_1_2D = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
TABLE_1_3D = [
    *[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    *[(2, 0, 0), (1, 1, 0), (0, 2, 0), (1, 0, 1), (0, 1, 1), (0, 0, 2)],
]


@pytest.mark.parametrize("table", [TABLE_1_2D, TABLE_1_3D])
def test_order_is_that_of_table_1(table: list[tuple[int, ...]]) -> None:
    assert [tuple(row) for row in graded.exponents(len(table[0]), 3)[: len(table)]] == table


@pytest.mark.parametrize(("dimension", "degree"), [(1, 9), (2, 40), (3, 20)])
def test_index_formula_inverts_the_order(dimension: int, degree: int) -> None:
    table = graded.exponents(dimension, degree)
    assert len(table) == graded.count(dimension, degree)
    np.testing.assert_array_equal(graded.column(table), np.arange(len(table)))


def test_index_formulas_agree_with_the_stops_of_figure_3() -> None:
    # α counts from 1: the whole sixth form, xy⁸ in the ninth, x¹³ opening the thirteenth
    stops = np.array([[0, 6], [1, 8], [13, 0]])
    assert (graded.column(stops) + 1).tolist() == [28, 54, 92]


@pytest.mark.parametrize("dimension", [2, 3])
def test_lower_degree_is_a_prefix(dimension: int) -> None:
    high = graded.exponents(dimension, 8)
    np.testing.assert_array_equal(graded.exponents(dimension, 5), high[: graded.count(dimension, 5)])
    assert set(high[graded.form(dimension, 8)].sum(axis=1)) == {8}


def test_exponents_cannot_be_changed_by_a_caller() -> None:
    with pytest.raises(ValueError, match="read-only"):
        graded.exponents(2, 3)[0, 0] = 7


def test_products_are_the_monomials() -> None:
    x = np.array([[2.0, 3.0, 5.0]]).T
    powers = graded.exponents(3, 4)
    tables = [np.vander(row, 5, increasing=True).T for row in x]
    np.testing.assert_array_equal(graded.products(tables, powers)[:, 0], (x[:, 0] ** powers).prod(axis=1))
