import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ipcore import Diagnostics, FitWarning, NormalSource, StopReason, WarningCode
from ipcore.search.fit_warnings import DataFindings, fit_warnings

GOOD = Diagnostics(0.005, 0.99, 0.01, 0.02, 0.0, 1, NormalSource.GIVEN, 0.95, quiet=True, unsure=0.01, outliers=0.0)


def test_a_good_fit_has_no_warnings() -> None:
    for reason in (StopReason.CRITERION_MET, StopReason.CRITERION_MINIMUM, StopReason.DEGREE_REACHED):
        assert fit_warnings(GOOD, reason, 0.0) == []
    unknown = replace(GOOD, stray=None, quiet=None, unsure=None, outliers=None, orthogonality_loss=None)
    assert fit_warnings(unknown, StopReason.CRITERION_MET, 0.0) == []


@pytest.mark.parametrize(
    "reason", [StopReason.MAX_DEGREE, StopReason.TOO_FEW_POINTS, StopReason.PLANAR, StopReason.ILL_CONDITIONED]
)
def test_a_search_that_ended_otherwise_than_asked_comes_with_advice(reason: StopReason) -> None:
    assert fit_warnings(GOOD, reason, 0.0) == [FitWarning(WarningCode(reason.value), reason.advice)]


@pytest.mark.parametrize(
    ("name", "tolerated", "too_much", "code", "text"),
    [
        ("normal_self_check", 0.9, 0.899, "normals-doubtful", "Only 90% of the normals"),
        ("quiet", None, False, "not-quiet", "away from the data or in pieces"),
        ("unsure", 0.05, 0.061, "sides-unknown", "In 6% of the box"),
        ("outliers", 0.0, 0.013, "outliers", "1.3% of the points were taken for outliers"),
        ("stray", 0.001, 0.0011, "stray", "0.1% of the zero set"),
        ("coverage", 0.9, 0.88, "low-coverage", "Only 88% of the points"),
        ("merged", 0, 3, "copies-merged", "3 points were copies"),
        ("orthogonality_loss", 1e-3, 2e-3, "orthogonality-lost", "‖QᵀQ − I‖ = 2.0e-03"),
    ],
)
def test_a_figure_over_its_limit_is_a_warning(name: str, tolerated: Any, too_much: Any, code: str, text: str) -> None:  # noqa: ANN401 - of a field each
    assert fit_warnings(replace(GOOD, **{name: tolerated}), StopReason.CRITERION_MET, 0.0) == []
    (warning,) = fit_warnings(replace(GOOD, **{name: too_much}), StopReason.CRITERION_MET, 0.0)
    assert text in warning.message
    assert warning.code == code


def test_coefficients_that_move_the_zero_set_are_a_warning() -> None:
    assert fit_warnings(GOOD, StopReason.CRITERION_MET, 1e-8) == []
    (warning,) = fit_warnings(GOOD, StopReason.CRITERION_MET, 2e-8)
    assert "up to 2.0e-08 mean radii" in warning.message
    assert warning.code == "rounding"


def test_without_a_zero_set_that_alone_is_said_of_it() -> None:
    none = replace(GOOD, components=0, coverage=0.0, stray=None, quiet=False)
    assert [warning.code for warning in fit_warnings(none, StopReason.CRITERION_MET, 0.0)] == ["no-zero-set"]


@pytest.mark.parametrize(
    ("found", "code", "text"),
    [
        (DataFindings(incomplete=1), "incomplete-points", "1 point was"),
        (DataFindings(setting_unit=2), "few-points-set-unit", "2 points were"),
        (DataFindings(inward=True), "normals-inward", "multiply the normals by -1"),
    ],
)
def test_what_is_found_of_the_data_is_a_warning(found: DataFindings, code: str, text: str) -> None:
    bad = replace(GOOD, normal_self_check=0.0) if found.inward else GOOD
    (warning,) = fit_warnings(bad, StopReason.CRITERION_MET, 0.0, found)
    assert warning.code == code
    assert text in warning.message


def test_every_code_stands_in_the_table_of_the_docs() -> None:
    page = (Path(__file__).parents[3] / "docs" / "warnings.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `([a-z-]+)` \|", page, re.MULTILINE) == [str(code) for code in WarningCode] + ["uncoded"]
