"""Checks of options that are allowed each on its own, but not together. Every check raises `InvalidOptionsError`."""

from ipcore.constraints.registry import LAYERED_NAMES, Constraints
from ipcore.errors import InvalidOptionsError
from ipcore.options.choices import Collinear, Criterion, Factor, Ridge


def check_least_squares(constraints: Constraints, ridge: Ridge, criterion: Criterion) -> None:
    """Check that a family whose fit is an eigenvector is not given options that need a least-squares fit."""
    if constraints.family.is_least_squares:
        return
    if ridge is not Ridge.NONE:
        raise InvalidOptionsError(f"ridge needs a right-hand side, and {constraints} has none", ("ridge",))
    if criterion.needs_least_squares:
        raise InvalidOptionsError(
            f"criterion {criterion} needs a least-squares fit, and {constraints} is an eigenvector", ("criterion",)
        )


def check_collinear(collinear: Collinear | None, ridge: Ridge) -> None:
    """Check that collinear columns are ridged exactly if the ridge is selective; None agrees with every ridge."""
    if collinear is not None and (collinear is Collinear.RIDGE) != (ridge is Ridge.SELECTIVE):
        raise InvalidOptionsError(
            f"collinear is ridge exactly when ridge is selective, not {collinear} with ridge {ridge}", ("collinear",)
        )


def check_factor(factor: Factor, constraints: Constraints, criterion: Criterion, *, needs_rows: bool) -> None:
    """Check that a factorisation that does not hold M can do what the family and the criterion need."""
    if factor not in {Factor.MOMENTS, Factor.TSQR}:
        return
    if needs_rows:
        reason = f"criterion {criterion}" if criterion.needs_rows else f"constraints {constraints}"
        raise InvalidOptionsError(f"{reason} needs the rows that factor {factor} does not keep", ("factor",))
    if factor is Factor.MOMENTS and not constraints.family.layer_offsets(1.0):
        raise InvalidOptionsError(
            f"factor moments is for constraints {LAYERED_NAMES}, not {constraints}; take tsqr", ("factor",)
        )


def check_linear(
    *, needs_linear: bool, signs: bool | None, geometric: bool | None, robust: bool, is_linear: bool
) -> None:
    """Check that a linear fit is not given options that only the geometric fit, or that under sign constraints, has.

    `needs_linear` says that another option exists only for linear fits, `is_linear` that the fit will be linear.
    """
    if needs_linear and (signs or geometric):
        name = "geometric" if geometric else "signs"
        raise InvalidOptionsError(
            f"{name} goes with 3l constraints, complete forms, no ridge, and the criterion distance or none", (name,)
        )
    if robust and is_linear:
        raise InvalidOptionsError("robust needs the geometric fit, or that under sign constraints", ("robust",))
