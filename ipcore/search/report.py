"""Makes the result of a search: the best fit in the answer's basis and raw coordinates, measured, with warnings."""

from functools import cache
from importlib.metadata import version

from ipcore.polynomial.univariate import Basis
from ipcore.search.closeness import delivery_shift
from ipcore.search.degree_search import Candidate, DegreeSearch
from ipcore.search.diagnostics import diagnose
from ipcore.search.fit_warnings import DataFindings, fit_warnings
from ipcore.search.result import FitResult
from ipcore.search.stop_reason import StopReason


def fit_result(search: DegreeSearch, best: Candidate, reason: StopReason, input_sha256: str) -> FitResult:
    """Return the result of a search that has run; `best` and `reason` are what it returned."""
    data, options = search.data, search.options
    fitted = best.fit.polynomial
    delivered = fitted.to_monomial() if options.basis is Basis.MONOMIAL else fitted.to_chebyshev()
    loss = search.fitter.orthogonality_loss(best.step.columns)
    diagnostics, proof = diagnose(best, delivered, data, options, loss)
    found = DataFindings.of(data, diagnostics.normal_self_check)
    warnings = fit_warnings(diagnostics, reason, delivery_shift(fitted, delivered, data), found)
    return FitResult(
        polynomial=data.to_raw(delivered),
        stop_reason=reason,
        steps=tuple(search.steps),
        diagnostics=diagnostics,
        proof=None if proof is None else proof.to_raw(data.frame),
        warnings=tuple(warnings),
        options=options,
        version=_version(),
        input_sha256=input_sha256,
    )


@cache
def _version() -> str:
    """Return the version of this library; reading it takes as long as extracting a small fit's zero set."""
    return version("ipfit")
