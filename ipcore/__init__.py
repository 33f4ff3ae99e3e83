"""Implicit polynomials f(x) = 0 from 2D and 3D point sets, of the degree that they need."""

from ipcore.errors import (
    InvalidNormalsError,
    InvalidOptionsError,
    InvalidPointsError,
    InvalidPolynomialError,
    IPCoreError,
)
from ipcore.fitting import fit, fit_fixed
from ipcore.moments import Moments
from ipcore.options.choices import Collinear, Constraints, Criterion, Factor, Granularity, Preset, Ridge, RidgeMatrix
from ipcore.options.fit_options import FitOptions
from ipcore.planning import Plan, plan
from ipcore.points.normals import NormalSource, estimate_normals
from ipcore.points.validation import PointSet
from ipcore.points.validation import check as check_points
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.search.result import Diagnostics, FitResult, Step, StopReason
from ipcore.zero_set.zero_set import ZeroSet, zero_set

__all__ = [
    "Basis",
    "Collinear",
    "Constraints",
    "Criterion",
    "Diagnostics",
    "Factor",
    "FitOptions",
    "FitResult",
    "Frame",
    "Granularity",
    "IPCoreError",
    "ImplicitPolynomial",
    "InvalidNormalsError",
    "InvalidOptionsError",
    "InvalidPointsError",
    "InvalidPolynomialError",
    "Moments",
    "NormalSource",
    "Plan",
    "PointSet",
    "Preset",
    "Ridge",
    "RidgeMatrix",
    "Step",
    "StopReason",
    "ZeroSet",
    "check_points",
    "estimate_normals",
    "fit",
    "fit_fixed",
    "plan",
    "zero_set",
]
