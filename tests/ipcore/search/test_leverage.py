import numpy as np
import pytest

from ipcore._typing import FloatArray
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.search.leverage import Leverage


def least_squares(count: int, groups: int, columns: int) -> tuple[FloatArray, FloatArray]:
    generator = np.random.default_rng(4)
    return generator.normal(size=(groups * count, columns)), generator.normal(size=groups * count)


@pytest.mark.parametrize("groups", [1, 3])
@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_leaving_points_out_is_fitting_without_all_their_rows(groups: int, damping: float) -> None:
    count, columns = 40, 9
    M, b = least_squares(count, groups, columns)
    policy = Policy(1e-12, full=damping > 0.0)
    factor = BlockGramSchmidt(b, policy, columns if damping else 0)
    leverage = Leverage(groups, count)
    for part in (slice(0, 4), slice(4, columns)):
        factor.append(M[:, part], np.full(part.stop - part.start, damping))
        leverage.add(factor.q_blocks(leverage.columns))
    errors = []
    for point in range(count):  # the definition: fit without the point's rows, and predict them
        rows = np.arange(groups) * count + point
        rest = np.delete(np.arange(groups * count), rows)
        a = np.linalg.solve(M[rest].T @ M[rest] + damping * np.eye(columns), M[rest].T @ b[rest])
        errors.append((M[rows] @ a - b[rows]) ** 2)
    assert leverage.leave_one_out_error(factor.residual) == pytest.approx(float(np.mean(errors)), rel=1e-9)


def test_a_point_that_alone_determines_a_coefficient_cannot_be_left_out() -> None:
    leverage = Leverage(1, 2)
    leverage.add([np.eye(2)])
    assert leverage.leave_one_out_error(np.zeros(2)) == float("inf")
