"""The warnings of a result: what its diagnostics show that a careful user should know, in plain words."""

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


def warning_texts(diagnostics: Diagnostics, reason: StopReason, shift: float) -> list[str]:
    """Return the warnings: of the search, the data, the zero set, and rounding.

    `shift` is the maximum distance, in mean radii, by which delivering in another basis moves the zero set at the data.
    """
    warnings = [] if reason.is_expected else [reason.advice]
    return [*warnings, *_of_the_data(diagnostics), *_of_the_zero_set(diagnostics), *_of_rounding(diagnostics, shift)]


def _of_the_data(diagnostics: Diagnostics) -> list[str]:
    texts = []
    if diagnostics.normal_self_check < TRUSTED_NORMALS:
        texts.append(
            f"Only {diagnostics.normal_self_check:.0%} of the normals agree with the inside that all of them describe: "
            "the surface is open or very thin, or some normals point the wrong way."
        )
    return texts


def _of_the_zero_set(diagnostics: Diagnostics) -> list[str]:
    texts = []
    if diagnostics.quiet is False:
        texts.append("The zero set has parts away from the data or in pieces that no constraint could remove.")
    if (diagnostics.unsure or 0.0) > TOLERATED_UNSURE:
        texts.append(
            f"In {diagnostics.unsure:.0%} of the box the points do not tell inside from outside, because the surface "
            "is open or sparse there: the sign of f was not constrained there, and may be wrong."
        )
    if diagnostics.outliers:
        texts.append(
            f"{diagnostics.outliers:.1%} of the points were taken for outliers: neither the fit nor any other figure "
            "counts them."
        )
    if diagnostics.stray is not None and diagnostics.stray > TOLERATED_STRAY:
        texts.append(
            f"{diagnostics.stray:.1%} of the zero set within the bounds lies away from all data; a mesh restricted to "
            "the data leaves it out, the sign of f does not."
        )
    return texts


def _of_rounding(diagnostics: Diagnostics, shift: float) -> list[str]:
    texts = []
    if (diagnostics.orthogonality_loss or 0.0) > TOLERATED_ORTHOGONALITY_LOSS:
        texts.append(
            f"Eq. (5) has lost orthogonality, ‖QᵀQ − I‖ = {diagnostics.orthogonality_loss:.1e}: the coefficients are "
            "not those of least squares. The block factorisation does not lose it."
        )
    if shift > DELIVERY_TOLERANCE:
        texts.append(
            f"The monomial coefficients move the zero set by up to {shift:.1e} mean radii at the data: "
            "ask for the Chebyshev basis."
        )
    return texts
