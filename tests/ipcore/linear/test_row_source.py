"""Where R of a fit that never holds M comes from: moments or rows, and up to which degree."""

from typing import Any

import pytest

from ipcore import FitOptions
from ipcore.linear import q_less
from ipcore.linear.layer_moments import LayerMoments
from ipcore.linear.q_less import QLessFit
from ipcore.linear.qr.r_factor import RFactor
from ipcore.linear.row_source import DataRows, SummedRows
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check as check_points
from ipcore.polynomial import graded
from tests.ipcore.linear.rough_shapes import rough


class Recorded(DataRows):
    """Records how R was computed, and up to which degree."""

    def __init__(self, data: OrientedPoints, options: FitOptions) -> None:
        super().__init__(data, options)
        self.calls: list[tuple[str, int]] = []

    def from_moments(self, degree: int) -> RFactor:
        self.calls.append(("moments", degree))
        return super().from_moments(degree)

    def from_rows(self, degree: int) -> RFactor:
        self.calls.append(("rows", degree))
        return super().from_rows(degree)


def recorded(
    count: int,
    max_degree: int,
    degrees: list[int],
    **given: Any,  # noqa: ANN401 - options
) -> list[tuple[str, int]]:
    """Return the calls for fits of these degrees to points in the plane."""
    data = OrientedPoints.of(check_points(*rough(2, count)), 12)
    options = FitOptions.of(**({"geometric": False} | given))
    source = Recorded(data, options)
    fitter = QLessFit(data, options, max_degree, source)
    for degree in degrees:
        assert fitter.raise_to(graded.count(2, degree)) is not None
    return source.calls


@pytest.mark.parametrize(
    ("given", "way"),
    [
        ({"factor": "auto"}, "rows"),  # small
        ({"factor": "moments"}, "moments"),
        ({"factor": "tsqr"}, "rows"),
        ({"constraints": "3l+gradient"}, "rows"),
    ],
)
def test_moments_are_summed_if_they_determine_the_fit_and_are_worth_it(given: dict[str, Any], way: str) -> None:
    assert [call for call, _ in recorded(500, 4, [2], **given)] == [way]


def test_a_system_is_small_up_to_a_number_of_entries(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = 3 * 500 * graded.count(2, 4)
    for limit, way in ((entries, "rows"), (entries - 1, "moments")):
        monkeypatch.setattr(q_less, "SMALL_SYSTEM_ENTRIES", limit)
        assert [call for call, _ in recorded(500, 4, [2])] == [way]


def test_r_is_computed_for_some_degrees_more_than_are_needed_but_never_for_more_than_can_be() -> None:
    assert recorded(500, 20, [1, 6, 7, 10], criterion="gcv") == [("rows", 6), ("rows", 11)]
    assert recorded(500, 8, [1, 7], criterion="gcv") == [("rows", 6), ("rows", 8)]
    assert recorded(500, 8, [1, 7], criterion="none") == [("rows", 8)]  # where every degree will be fitted
    # 12 points determine 12 columns, which end in degree 4
    assert recorded(12, 20, [1], criterion="none") == [("rows", 4)]
    assert recorded(6, 20, [1], criterion="none") == [("rows", 2)]
    assert recorded(500, 4, [4], factor="moments") == [("moments", 4)]  # no more is needed than there is


def test_moments_that_were_summed_before_are_used_as_far_as_they_reach() -> None:
    data = OrientedPoints.of(check_points(*rough(2, 200)), 12)
    options = FitOptions.of(geometric=False)
    some = LayerMoments.of(data.points[:100], data.normals[:100], 5, options.layer_offsets)  # not of all the points
    source = SummedRows(data, options, some)
    assert source.from_moments(5).rows == 300
    assert source.from_moments(6).rows == 600
