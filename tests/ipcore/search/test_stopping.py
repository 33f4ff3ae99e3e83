import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.search.leverage import Leverage
from ipcore.search.stopping import bic, gcv
from ipcore.search.stopping_rule import StoppingRule

RULE = StoppingRule(0.01, 0.95)


@pytest.mark.parametrize(
    ("d_dist", "d_smooth", "met"),
    [(0.009, 0.96, True), (0.01, 0.96, False), (0.009, 0.95, False), (float("nan"), 0.96, False)],
)
def test_rule_is_equation_7(d_dist: float, d_smooth: float, *, met: bool) -> None:
    assert RULE.met(d_dist, d_smooth) is met


@given(st.floats(0.0, 1.0), st.floats(-1.0, 1.0))
def test_excess_is_below_one_exactly_when_the_rule_is_met(d_dist: float, d_smooth: float) -> None:
    excess = RULE.excess(d_dist, d_smooth)
    if abs(excess - 1.0) > 1e-12:  # at the edge itself rounding decides
        assert (excess < 1.0) == RULE.met(d_dist, d_smooth)


def test_generalised_cross_validation_is_leave_one_out_with_every_leverage_alike() -> None:
    M = np.exp(2j * np.pi * np.outer(np.arange(12), np.arange(1, 3)) / 12).view(float)  # a tight frame: H_ii = 4/12
    b = np.random.default_rng(1).normal(size=12)
    factor, leverage = BlockGramSchmidt(b, Policy(1e-12)), Leverage(1, 12)
    factor.append(M)
    leverage.add(factor.q_blocks())
    assert gcv(12, factor.degrees_of_freedom, factor.rss) == pytest.approx(
        leverage.leave_one_out_error(factor.residual), rel=1e-12
    )
    assert gcv(4, 4.0, 0.0) == float("inf")


def test_bic_is_minus_twice_the_log_likelihood_plus_k_log_n() -> None:
    rows, k, rss = 50, 7.0, 2.5
    variance = rss / rows  # Gaussian errors of this variance, the constant n(1 + ln 2π) left out
    log_likelihood = -rows / 2 * (np.log(2 * np.pi * variance) + 1.0)
    expected = -2.0 * log_likelihood - rows * (1.0 + np.log(2 * np.pi)) + k * np.log(rows)
    assert bic(rows, k, rss) == pytest.approx(float(expected), rel=1e-12)
    assert np.isfinite(bic(rows, k, 0.0))
