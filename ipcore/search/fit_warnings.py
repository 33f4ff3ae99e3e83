"""The warnings of a result: what its diagnostics show that a careful user should know."""

from dataclasses import dataclass

from ipcore.points.far_points import setting_the_unit
from ipcore.points.normals import NormalSource
from ipcore.points.oriented import OrientedPoints
from ipcore.points.winding import self_check
from ipcore.search.coverage import COVERED_T1, LEAST_COVERAGE
from ipcore.search.fit_warning import FitWarning, WarningCode
from ipcore.search.result import Diagnostics
from ipcore.search.stop_reason import StopReason

# The delivered coefficients may move the zero set by this much at the data, in mean radii, before a warning says so.
DELIVERY_TOLERANCE = 1e-8
# Below this share of agreeing normals their orientation is in doubt: over 28 sets with known normals the share tracked
# the truth with rank correlation 0.9, and correctly oriented closed shapes lay above.
TRUSTED_NORMALS = 0.9
# Share of the zero set that may be stray before a warning says so; `bench/QUALITY.md` calls a fit good below it.
TOLERATED_STRAY = 0.001
# ‖QᵀQ − I‖ above which a warning says so: about the relative error that it causes in the solution.
TOLERATED_ORTHOGONALITY_LOSS = 1e-3
# Share of the box with unknown sides above which a warning says so: closed shapes have less than 2 %, scans more.
TOLERATED_UNSURE = 0.05


@dataclass(frozen=True)
class DataFindings:
    """What was found of the data themselves.

    Attributes
    ----------
    incomplete
        How many points were left out because a value of theirs was missing.
    setting_unit
        How many points, far from all others, make the unit of length much larger.
    inward
        Whether the normals agree with the inside that they describe when all are reversed.

    """

    incomplete: int = 0
    setting_unit: int = 0
    inward: bool = False

    @classmethod
    def of(cls, data: OrientedPoints, normal_self_check: float) -> "DataFindings":
        """Return what is found of these data; `normal_self_check` is that of the diagnostics."""
        inward = (
            data.source is NormalSource.GIVEN
            and normal_self_check < 1.0 - TRUSTED_NORMALS
            and self_check(data.points, -data.normals) >= TRUSTED_NORMALS
        )
        return cls(data.incomplete, setting_the_unit(data.points), inward)


def fit_warnings(
    diagnostics: Diagnostics, reason: StopReason, shift: float, found: DataFindings | None = None
) -> list[FitWarning]:
    """Return the warnings: of the search, the data, the zero set, and rounding.

    `shift` is the maximum distance, in mean radii, by which delivering in another basis moves the zero set at the data.
    """
    search = [] if reason.is_expected else [FitWarning(WarningCode(reason.value), reason.advice)]
    found = found or DataFindings()
    out = [*search, *_of_the_points(diagnostics, found)]
    if reason is not StopReason.PLANAR:  # a plane is open and has no inside: no other cause has to be named
        out += _of_the_normals(diagnostics.normal_self_check, inward=found.inward)
        out += _of_the_zero_set(diagnostics, inward=found.inward)
    return [*out, *_of_rounding(diagnostics, shift)]


def _of_the_points(diagnostics: Diagnostics, found: DataFindings) -> list[FitWarning]:
    out = []
    if found.incomplete:
        text = f"{_points(found.incomplete)} with a missing value left out."
        out.append(FitWarning(WarningCode.INCOMPLETE_POINTS, text))
    if diagnostics.merged:
        text = f"{_points(diagnostics.merged)} copies of others; each place is fitted once."
        out.append(FitWarning(WarningCode.COPIES_MERGED, text))
    if diagnostics.outliers:
        text = (
            f"{diagnostics.outliers:.1%} of the points were taken for outliers: neither the fit nor any other figure "
            "counts them."
        )
        out.append(FitWarning(WarningCode.OUTLIERS, text))
    if found.setting_unit:
        text = (
            f"{_points(found.setting_unit)} so far from all others that they set the unit of length, in which the rest "
            "is small. If they are errors of measurement, remove them or set robust=true, which leaves them out."
        )
        out.append(FitWarning(WarningCode.FEW_POINTS_SET_UNIT, text))
    return out


def _points(count: int) -> str:
    return "1 point was" if count == 1 else f"{count} points were"


def _of_the_normals(self_check: float, *, inward: bool) -> list[FitWarning]:
    if inward:
        text = (
            "All normals point inward, so that f is negative outside: multiply the normals by -1 to have the inside "
            "negative."
        )
        return [FitWarning(WarningCode.NORMALS_INWARD, text)]
    if self_check < TRUSTED_NORMALS:
        text = (
            f"Only {self_check:.0%} of the normals agree with the inside that all of them describe: the surface is "
            "open, or some normals point the wrong way. Give outward normals, or close the surface, if it is to be "
            "closed."
        )
        return [FitWarning(WarningCode.NORMALS_DOUBTFUL, text)]
    return []


def _of_the_zero_set(diagnostics: Diagnostics, *, inward: bool) -> list[FitWarning]:
    out = []
    covered = 1.0 if diagnostics.coverage is None else diagnostics.coverage
    if diagnostics.components == 0 and not covered:
        text = (
            "There is no zero set within the bounds: the points do not determine one up to this degree. Give more "
            "points, or raise max_degree."
        )
        return [FitWarning(WarningCode.NO_ZERO_SET, text)]
    if covered < LEAST_COVERAGE:
        text = (
            f"Only {covered:.0%} of the points have the zero set within {COVERED_T1:g} t1: parts of the shape are "
            "missed. Raise max_degree, or t1 if that is the noise."
        )
        out.append(FitWarning(WarningCode.LOW_COVERAGE, text))
    if diagnostics.quiet is False:
        text = (
            "The zero set has, or may have, parts away from the data or in pieces that no constraint could remove: "
            "take a lower max_degree, or more points where they are sparse. `proof.uncleared` says where it may."
        )
        out.append(FitWarning(WarningCode.NOT_QUIET, text))
    if (diagnostics.unsure or 0.0) > TOLERATED_UNSURE and not inward:  # else that is the cause, and was named
        text = (
            f"In {diagnostics.unsure:.0%} of the box the points do not tell inside from outside, because the surface "
            "is open or sparse there: the sign of f was not constrained there, and may be wrong."
        )
        out.append(FitWarning(WarningCode.SIDES_UNKNOWN, text))
    if diagnostics.stray is not None and diagnostics.stray > TOLERATED_STRAY:
        text = (
            f"{diagnostics.stray:.1%} of the zero set within the bounds lies away from all data; a mesh restricted to "
            "the data leaves it out, the sign of f does not."
        )
        out.append(FitWarning(WarningCode.STRAY, text))
    return out


def _of_rounding(diagnostics: Diagnostics, shift: float) -> list[FitWarning]:
    out = []
    if (diagnostics.orthogonality_loss or 0.0) > TOLERATED_ORTHOGONALITY_LOSS:
        text = (
            f"Eq. (5) has lost orthogonality, ‖QᵀQ − I‖ = {diagnostics.orthogonality_loss:.1e}: the coefficients are "
            "not those of least squares. The block factorisation does not lose it."
        )
        out.append(FitWarning(WarningCode.ORTHOGONALITY_LOST, text))
    if shift > DELIVERY_TOLERANCE:
        text = (
            f"The monomial coefficients move the zero set by up to {shift:.1e} mean radii at the data: "
            "ask for the Chebyshev basis."
        )
        out.append(FitWarning(WarningCode.ROUNDING, text))
    return out
