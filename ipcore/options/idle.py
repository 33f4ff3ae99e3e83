"""Options that cannot act beside the others: a value given to one of them would change nothing, so it is refused."""

from typing import NamedTuple

from ipcore.constraints.family import Family
from ipcore.errors import InvalidOptionsError


class Acting(NamedTuple):
    """What the chosen fit is, as far as it decides which options act."""

    is_linear: bool
    family: Family
    has_ridge: bool
    drops_columns: bool
    by_distance: bool


def reason_idle(name: str, fit: Acting) -> str | None:
    """Return when the option `name` acts, if it cannot act in this fit; None if it acts or is none of those here.

    >>> from ipcore.constraints.three_layer import ThreeLayer
    >>> geometric = Acting(False, ThreeLayer(), has_ridge=False, drops_columns=True, by_distance=True)
    >>> reason_idle("layer_distance", geometric)
    'it acts in linear fits (geometric=false) with constraints of layers'
    >>> reason_idle("t2", geometric) is None
    True
    """
    acts, when = {
        "layer_distance": (
            fit.is_linear and fit.family.uses_layer_distance,
            "in linear fits (geometric=false) with constraints of layers",
        ),
        "gradient_weight": (
            fit.is_linear and fit.family.uses_gradient_weight,
            "in linear fits (geometric=false) with constraints on gradients",
        ),
        "collinear_tol": (
            fit.is_linear and fit.drops_columns,
            "in linear fits (geometric=false) that drop or ridge collinear columns",
        ),
        "ridge_matrix": (fit.has_ridge, "with ridge full or selective"),
        "ridge_strength": (fit.has_ridge, "with ridge full or selective"),
        "angle_weight": (not fit.is_linear, "in the geometric fit, or that under sign constraints"),
        "t2": (not fit.is_linear or fit.by_distance, "with criterion distance, or in the geometric fit"),
    }.get(name, (True, ""))
    return None if acts else f"it acts {when}"


def check_acting(name: str, fit: Acting) -> None:
    """Raise `InvalidOptionsError`, with the option's name as its place, if the option `name` cannot act in this fit."""
    reason = reason_idle(name, fit)
    if reason is not None:
        raise InvalidOptionsError(f"{name} has no effect with these options: {reason}", (name,))
