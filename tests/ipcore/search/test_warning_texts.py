from dataclasses import replace
from typing import Any

import pytest

from ipcore import Diagnostics, NormalSource, StopReason
from ipcore.search.warning_texts import warning_texts

GOOD = Diagnostics(0.005, 0.99, 0.01, 0.02, 0.0, 1, NormalSource.GIVEN, 0.95, quiet=True, unsure=0.01, outliers=0.0)


def test_a_good_fit_has_no_warnings() -> None:
    for reason in (StopReason.CRITERION_MET, StopReason.CRITERION_MINIMUM, StopReason.DEGREE_REACHED):
        assert warning_texts(GOOD, reason, 0.0) == []
    unknown = replace(GOOD, stray=None, quiet=None, unsure=None, outliers=None, orthogonality_loss=None)
    assert warning_texts(unknown, StopReason.CRITERION_MET, 0.0) == []


@pytest.mark.parametrize(
    "reason", [StopReason.MAX_DEGREE, StopReason.TOO_FEW_POINTS, StopReason.PLANAR, StopReason.ILL_CONDITIONED]
)
def test_a_search_that_ended_otherwise_than_asked_comes_with_advice(reason: StopReason) -> None:
    assert warning_texts(GOOD, reason, 0.0) == [reason.advice]


@pytest.mark.parametrize(
    ("name", "tolerated", "too_much", "text"),
    [
        ("normal_self_check", 0.9, 0.899, "Only 90% of the normals"),
        ("quiet", None, False, "away from the data or in pieces"),
        ("unsure", 0.05, 0.061, "In 6% of the box"),
        ("outliers", 0.0, 0.013, "1.3% of the points were taken for outliers"),
        ("stray", 0.001, 0.0011, "0.1% of the zero set"),
        ("orthogonality_loss", 1e-3, 2e-3, "‖QᵀQ − I‖ = 2.0e-03"),
    ],
)
def test_a_figure_over_its_limit_is_a_warning(name: str, tolerated: Any, too_much: Any, text: str) -> None:  # noqa: ANN401 - of a field each
    assert warning_texts(replace(GOOD, **{name: tolerated}), StopReason.CRITERION_MET, 0.0) == []
    (warning,) = warning_texts(replace(GOOD, **{name: too_much}), StopReason.CRITERION_MET, 0.0)
    assert text in warning


def test_coefficients_that_move_the_zero_set_are_a_warning() -> None:
    assert warning_texts(GOOD, StopReason.CRITERION_MET, 1e-8) == []
    (warning,) = warning_texts(GOOD, StopReason.CRITERION_MET, 2e-8)
    assert "up to 2.0e-08 mean radii" in warning
