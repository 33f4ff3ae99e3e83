"""Why a search over degrees ended, with advice on what to do about it."""

from enum import StrEnum


class StopReason(StrEnum):
    """Why no higher degree was tried."""

    CRITERION_MET = "criterion-met"
    MAX_DEGREE = "max-degree"
    TOO_FEW_POINTS = "too-few-points"
    PLANAR = "planar"
    CRITERION_MINIMUM = "criterion-minimum"
    DEGREE_REACHED = "degree-reached"
    ILL_CONDITIONED = "ill-conditioned"

    @property
    def advice(self) -> str:
        """Return what happened and what to do about it, in one sentence."""
        return _ADVICE[self]

    @property
    def is_expected(self) -> bool:
        """Return whether the search ended as the options asked, so that no warning is needed."""
        return self in _EXPECTED


_ADVICE = {
    StopReason.CRITERION_MET: "The fit is as close and as smooth as was asked for.",
    StopReason.MAX_DEGREE: "No degree up to max_degree met the criterion, and the best one is returned: raise "
    "max_degree, or on noisy data raise t1 to about the noise or take another criterion, gcv say.",
    StopReason.TOO_FEW_POINTS: "The next degree has more coefficients than there are points, and the best fit so far "
    "is returned: give more points, or raise t1.",
    StopReason.PLANAR: "All points lie on one plane: degree 1 represents it, and no higher degree is determined.",
    StopReason.CRITERION_MINIMUM: "The criterion has passed its minimum, and the fit at the minimum is returned.",
    StopReason.DEGREE_REACHED: "The degree that was asked for is reached.",
    StopReason.ILL_CONDITIONED: "Moments alone do not determine the next degree, and the best fit so far is returned: "
    "fit the points themselves, or raise t1.",
}
_EXPECTED = {StopReason.CRITERION_MET, StopReason.CRITERION_MINIMUM, StopReason.DEGREE_REACHED}
