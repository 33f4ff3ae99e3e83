"""Which module a constraint family's name stands for, and which options it takes."""

from collections.abc import Callable

from ipcore._typing import FloatArray
from ipcore.linear.constraints import (
    five_layer,
    gradient_one,
    min_max,
    min_var,
    taubin,
    three_layer,
    three_layer_gradient,
)
from ipcore.linear.constraints.rows import Rows
from ipcore.options.choices import Constraints
from ipcore.options.fit_options import FitOptions

_FAMILIES: dict[Constraints, Callable[[FloatArray, FloatArray, FitOptions], Rows]] = {
    Constraints.THREE_LAYER: lambda x, n, o: three_layer.rows(x, n, o.layer_distance),
    Constraints.FIVE_LAYER: lambda x, n, o: five_layer.rows(x, n, o.layer_distance),
    Constraints.THREE_LAYER_GRADIENT: lambda x, n, o: three_layer_gradient.rows(
        x, n, o.layer_distance, o.gradient_weight
    ),
    Constraints.GRADIENT_ONE: lambda x, n, o: gradient_one.rows(x, n, o.gradient_weight),
    Constraints.MIN_MAX: lambda x, n, o: min_max.rows(x, n, o.gradient_weight),
    Constraints.MIN_VAR: lambda x, n, o: min_var.rows(x, n, o.gradient_weight),
    Constraints.TAUBIN: lambda x, _n, _o: taubin.rows(x),
}

_LAYERED: dict[Constraints, Callable[[float], tuple[float, ...]]] = {
    Constraints.THREE_LAYER: three_layer.offsets,
    Constraints.FIVE_LAYER: five_layer.offsets,
}


def rows(points: FloatArray, normals: FloatArray, options: FitOptions) -> Rows:
    """Return the rows of the chosen family; points and unit outward normals (N, d) in the normalised frame."""
    return _FAMILIES[options.constraints](points, normals, options)


def offsets(options: FitOptions) -> tuple[float, ...]:
    """Return the layers' offsets, in mean radii, of a family that asks for nothing but f on layers; else nothing."""
    layered = _LAYERED.get(options.constraints)
    return () if layered is None else layered(options.layer_distance)
