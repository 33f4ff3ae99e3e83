"""Fit implicit polynomials f(x) = 0 to 2D and 3D point sets, and find the degree that the points need."""

from ipcore._typing import BoolArray, FloatArray, IntArray
from ipcore.constraints.registry import Constraints
from ipcore.errors import (
    InvalidNormalsError,
    InvalidOptionsError,
    InvalidPointsError,
    InvalidPolynomialError,
    IPCoreError,
)
from ipcore.fitting import fit, fit_fixed
from ipcore.moments import Moments
from ipcore.options.choices import Collinear, Criterion, Factor, Granularity, Preset, Ridge, RidgeMatrix
from ipcore.options.degrees import DEFAULT_MAX_DEGREE, HIGHEST_DEGREE
from ipcore.options.fit_options import FitOptions
from ipcore.planning import Plan, plan
from ipcore.points.normals import NormalSource, estimate_normals
from ipcore.points.validation import PointSet
from ipcore.points.validation import check as check_points
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.polynomial.univariate import Basis
from ipcore.search.fit_warning import FitWarning, WarningCode
from ipcore.search.result import Diagnostics, FitResult, Step
from ipcore.search.stop_reason import StopReason
from ipcore.zero_set.mesh import cell_vectors
from ipcore.zero_set.mesh import labels as component_labels
from ipcore.zero_set.support import gap_radius, support_radius
from ipcore.zero_set.zero_set import ZeroSet, zero_set

__all__ = [
    "DEFAULT_MAX_DEGREE",
    "HIGHEST_DEGREE",
    "Basis",
    "BoolArray",
    "Collinear",
    "Constraints",
    "Criterion",
    "Diagnostics",
    "Factor",
    "FitOptions",
    "FitResult",
    "FitWarning",
    "FloatArray",
    "Frame",
    "Granularity",
    "IPCoreError",
    "ImplicitPolynomial",
    "IntArray",
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
    "WarningCode",
    "ZeroSet",
    "cell_vectors",
    "check_points",
    "component_labels",
    "estimate_normals",
    "fit",
    "fit_fixed",
    "gap_radius",
    "plan",
    "support_radius",
    "zero_set",
]
