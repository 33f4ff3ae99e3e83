from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcore import Criterion, FitOptions, Step, StopReason
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Policy
from ipcore.search.criteria import DEGREES_PAST_MINIMUM, bic, gcv, stopping_criterion
from ipcore.search.leverage import Leverage
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


STEP = Step(4, 15, 0, d_dist=0.02, d_smooth=0.96, rss=1.0, gcv=3.0, condition=1.0, seconds=0.0)


def test_among_fits_under_sign_constraints_a_quiet_one_is_better_than_any_other() -> None:
    criterion = stopping_criterion(FitOptions())
    quiet, checked, unchecked = (replace(STEP, quiet=quiet) for quiet in (True, False, None))
    far = replace(quiet, d_dist=100.0)
    scores = [criterion.score(step) for step in (quiet, far, checked, unchecked)]
    assert scores == sorted(scores)
    assert criterion.score(quiet) == pytest.approx(2.0)  # D_dist is twice T₁


@pytest.mark.parametrize(("quiet", "reason"), [(True, "criterion-met"), (None, "criterion-met"), (False, None)])
def test_a_close_fit_that_is_not_quiet_does_not_end_the_search(*, quiet: bool | None, reason: str | None) -> None:
    criterion = stopping_criterion(FitOptions())
    close = replace(STEP, d_dist=0.009, quiet=quiet)
    assert criterion.verdict(close, close) == reason
    assert criterion.verdict(replace(close, d_dist=0.01), close) is None


@pytest.mark.parametrize("name", ["gcv", "bic", "loo"])
def test_a_minimum_ends_the_search_some_degrees_after_it(name: str) -> None:
    criterion = stopping_criterion(FitOptions.of(criterion=name))
    best = replace(STEP, bic=1.0, loo=2.0)
    assert criterion.score(best) == {"gcv": 3.0, "bic": 1.0, "loo": 2.0}[name]
    ahead = [criterion.verdict(replace(best, degree=best.degree + more), best) for more in range(5)]
    reason = StopReason.CRITERION_MINIMUM
    assert ahead == [None] * DEGREES_PAST_MINIMUM + [reason] * (5 - DEGREES_PAST_MINIMUM)


def test_without_a_criterion_more_columns_are_better() -> None:
    criterion = stopping_criterion(FitOptions.of(criterion="none"))
    assert (
        criterion.score(replace(STEP, dropped=1)) < criterion.score(STEP) < criterion.score(replace(STEP, columns=14))
    )
    assert criterion.never_stops
    assert criterion.exhausted is StopReason.DEGREE_REACHED


@pytest.mark.parametrize("criterion", Criterion)
def test_every_criterion_has_the_rule_of_the_options(criterion: Criterion) -> None:
    t2 = 0.95 if criterion.needs_least_squares else 0.9  # these have no use for another one
    rule = stopping_criterion(FitOptions(criterion=criterion, t1=0.02, t2=t2)).rule
    assert (rule.t1, rule.t2) == (0.02, t2)


def test_a_value_that_was_not_recorded_is_an_error_and_not_a_number() -> None:
    with pytest.raises(ValueError, match="does not have the value"):
        stopping_criterion(FitOptions.of(criterion="bic")).score(STEP)
