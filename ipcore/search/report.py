"""Look at the fit as it will be delivered, and say what a careful user should know."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version
from typing import Any

from ipcore import _threads
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.leading_form import is_bounded
from ipcore.polynomial.univariate import Basis
from ipcore.search.closeness import closeness, moved, percentile
from ipcore.search.degree_search import DegreeSearch, Found, Progress
from ipcore.search.result import Diagnostics, FitResult, StopReason
from ipcore.zero_set.stray import straying

# The delivered coefficients may move the zero set by this much at the data, in mean radii, before a warning says so.
DELIVERY_TOLERANCE = 1e-8
# Below this share of agreeing normals their orientation is in doubt: over 28 sets with known normals the share tracked
# the truth with rank correlation 0.9, and correctly oriented closed shapes lay above.
TRUSTED_NORMALS = 0.9
QUIET = 0.001
# Relative error of the solution that lost orthogonality may cause before a warning says so.
LOST = 1e-3
# Share of the box with unknown sides above which a warning says so: closed shapes have less than 2 %, scans more.
UNSURE = 0.05
FEW = 4096  # points up to which other threads are not worth starting
# Ends that are what the caller asked for, and need no warning.
AS_ASKED = {StopReason.CRITERION_MET, StopReason.CRITERION_MINIMUM, StopReason.DEGREE_REACHED}


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The delivered polynomial, in raw coordinates, and what was found out about it."""

    polynomial: ImplicitPolynomial
    diagnostics: Diagnostics
    warnings: tuple[str, ...]


def diagnose(found: Found, data: OrientedPoints, options: FitOptions, orthogonality_loss: float | None) -> Diagnosis:
    """Deliver a polynomial of the normalised frame: change basis and coordinates, and measure what comes out."""
    best, weights = found.fitted, found.fitted.weights
    fitted = best.polynomial
    local = fitted.to_monomial() if options.basis is Basis.MONOMIAL else fitted.to_chebyshev()
    at = found.at if local is fitted else closeness(local, data, weights)
    (stray, components), self_check, bounded = _looks(local, fitted, data, options)
    diagnostics = Diagnostics(
        at.d_dist,
        at.d_smooth,
        percentile(local, data, 0.95),
        at.farthest,
        stray,
        components,
        data.source,
        self_check,
        bounded,
        orthogonality_loss,
        bool(best.quiet) if options.on_signs else None,
        best.unsure,
        None if weights is None else float((weights == 0.0).mean()),
    )
    warnings = _warnings(diagnostics, found.reason, moved(fitted, local, data))
    return Diagnosis(data.to_raw(local), diagnostics, tuple(warnings))


def _looks(
    local: ImplicitPolynomial, fitted: ImplicitPolynomial, data: OrientedPoints, options: FitOptions
) -> tuple[tuple[float | None, int | None], float, bool]:
    """Return stray share and components, what the normals' check says, and whether the zero set is bounded."""

    def zero_set() -> tuple[float | None, int | None]:
        return straying(local, data.thinned.points) if options.measure_zero_set else (None, None)

    threads = 1 if data.count < FEW else None
    looks: list[Any] = [zero_set, data.self_check, partial(is_bounded, fitted)]
    zeros, check, bounded = _threads.mapped(lambda look: look(), looks, threads)
    return zeros, check, bounded


def _warnings(diagnostics: Diagnostics, reason: StopReason, shift: float) -> list[str]:
    warnings = [] if reason in AS_ASKED else [reason.advice]
    if diagnostics.normal_self_check < TRUSTED_NORMALS:
        warnings.append(
            f"Only {diagnostics.normal_self_check:.0%} of the normals agree with the inside that all of them describe: "
            "the surface is open or very thin, or some normals point the wrong way."
        )
    if diagnostics.quiet is False:
        warnings.append("The zero set has parts away from the data or in pieces that no constraint could remove.")
    if (diagnostics.unsure or 0.0) > UNSURE:
        warnings.append(
            f"In {diagnostics.unsure:.0%} of the box the points do not tell inside from outside, for the surface is "
            "open or sparse there: nothing was asked of f, and its sign is a guess."
        )
    if diagnostics.outliers:
        warnings.append(f"{diagnostics.outliers:.1%} of the points were taken for outliers and do not count.")
    if diagnostics.stray is not None and diagnostics.stray > QUIET:
        warnings.append(
            f"{diagnostics.stray:.1%} of the zero set within the bounds lies away from all data; a mesh restricted to "
            "the data leaves it out, the sign of f does not."
        )
    if (diagnostics.orthogonality_loss or 0.0) > LOST:
        warnings.append(
            f"Eq. (5) has lost orthogonality, ‖QᵀQ − I‖ = {diagnostics.orthogonality_loss:.1e}: the coefficients are "
            "not those of least squares. The block factorisation does not lose it."
        )
    if shift > DELIVERY_TOLERANCE:
        warnings.append(
            f"The monomial coefficients move the zero set by up to {shift:.1e} mean radii at the data: "
            "ask for the Chebyshev basis."
        )
    return warnings


def answer(search: DegreeSearch, alphas: Sequence[int], progress: Progress | None, input_sha256: str) -> FitResult:
    """Search over these numbers of columns α, and report."""
    found = search.run(alphas, progress)
    loss = search.way.orthogonality_loss(found.step.columns)
    diagnosis = diagnose(found, search.data, search.options, loss)
    return FitResult(
        diagnosis.polynomial,
        found.reason,
        tuple(search.steps),
        diagnosis.diagnostics,
        diagnosis.warnings,
        search.options,
        _version(),
        input_sha256,
    )


@cache
def _version() -> str:
    """Return the library's version; to read it takes as long as a small fit's zero set."""
    return version("ipfit")
