"""What every way in ends with: search for the degree, look at the fit as it is delivered, say what was found."""

from collections.abc import Sequence
from functools import cache
from importlib.metadata import version

from ipcore.report import diagnose
from ipcore.result import FitResult
from ipcore.search import DegreeSearch, Progress


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
