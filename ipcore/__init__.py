"""Implicit polynomials f(x) = 0 from 2D and 3D point sets, of the degree that they need."""

from ipcore.adaptive import fit, fit_fixed
from ipcore.basis import Basis
from ipcore.choices import Collinear, Constraints, Criterion, Factor, Granularity, Preset, Ridge, RidgeMatrix
from ipcore.errors import (
    InvalidNormalsError,
    InvalidOptionsError,
    InvalidPointsError,
    InvalidPolynomialError,
    IPCoreError,
)
from ipcore.frame import Frame
from ipcore.moments import Moments
from ipcore.normals import NormalSource, estimate_normals
from ipcore.options import FitOptions
from ipcore.points import PointSet
from ipcore.points import check as check_points
from ipcore.polynomial import ImplicitPolynomial
from ipcore.result import Diagnostics, FitResult, Step, StopReason
from ipcore.zero_set import ZeroSet, zero_set

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
    "zero_set",
]
