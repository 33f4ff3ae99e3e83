"""Measures the polynomial as it will be delivered: in the basis of the answer, at the data, with its zero set."""

from collections.abc import Callable
from functools import partial
from typing import Any

from ipcore import _threads
from ipcore._typing import FloatArray
from ipcore.options.fit_options import FitOptions
from ipcore.points.oriented import OrientedPoints
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.leading_form import is_bounded
from ipcore.proof.prover import Proof, prove
from ipcore.search.closeness import closeness, distance_quantile
from ipcore.search.coverage import coverage
from ipcore.search.degree_search import Candidate
from ipcore.search.result import Diagnostics
from ipcore.zero_set.survey import straying

# Points below which other threads are not worth starting.
ONE_THREAD_POINTS = 4096


def diagnose(
    best: Candidate,
    delivered: ImplicitPolynomial,
    data: OrientedPoints,
    options: FitOptions,
    orthogonality_loss: float | None,
) -> tuple[Diagnostics, Proof | None]:
    """Return what is known of the polynomial `delivered`, the best fit in the basis of the answer, and what is proved.

    All are in the normalised frame.
    """
    fitted, weights = best.fit.polynomial, best.fit.weights
    at_data = best.closeness if delivered is fitted else closeness(delivered, data, weights)
    (stray, components, proof), self_check, bounded, covered = _in_parallel(
        [
            partial(_zero_set, delivered, data, options),
            data.self_check,
            partial(is_bounded, fitted),
            partial(coverage, delivered, data, options.t1, weights),
        ],
        data.count,
    )
    if (
        components == 0 and covered > 0.0
    ):  # f has zeros, in a part too small for the finest grid: nothing is known of it
        stray = components = None
    diagnostics = Diagnostics(
        d_dist=at_data.d_dist,
        d_smooth=at_data.d_smooth,
        distance_p95=distance_quantile(delivered, data, 0.95),
        distance_max=at_data.max_distance,
        stray=stray,
        components=components,
        normal_source=data.source,
        normal_self_check=self_check,
        bounded=bounded,
        orthogonality_loss=orthogonality_loss,
        quiet=_quiet(best, proof) if options.on_signs else None,
        unsure=best.fit.unsure,
        outliers=_outliers(data, weights) if options.robust else None,
        coverage=covered,
        merged=data.merged,
    )
    return diagnostics, proof


def _quiet(best: Candidate, proof: Proof | None) -> bool | None:
    """Return whether the zero set is quiet, which needs a proof; None if none was tried, as nothing was measured."""
    if not best.fit.quiet:
        return False
    return None if proof is None else proof.holds


def _outliers(data: OrientedPoints, weights: FloatArray | None) -> float:
    """Return the share of the distinct points that were left out, before the fit or in it, where their weight is 0."""
    left_out = data.outliers + (0 if weights is None else int((weights == 0.0).sum()))
    return left_out / (data.count + data.outliers)


def _zero_set(
    delivered: ImplicitPolynomial, data: OrientedPoints, options: FitOptions
) -> tuple[float | None, int | None, Proof | None]:
    """Return the stray share of the zero set, its number of components, and a proof; None for what is not known.

    What is proved is not measured. Of linear fits, which mostly stray, only what was not seen to stray is to be proved.
    """
    if not options.measure_zero_set:
        return None, None, None
    points = data.thinned.points
    proof = prove(delivered, points) if options.on_signs else None
    if proof is not None and proof.components:
        return 0.0, proof.components, proof
    stray, components = straying(delivered, points)
    if proof is None and stray == 0.0:
        proof = prove(delivered, points)
    return stray, components, proof


def _in_parallel(measurements: list[Callable[[], Any]], points: int) -> list[Any]:
    """Return the results of functions without arguments, called on several threads if there are many points."""
    return _threads.mapped(lambda measure: measure(), measurements, 1 if points < ONE_THREAD_POINTS else None)
