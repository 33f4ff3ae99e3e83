"""The options of one fit. Every option has a default; distances are in mean radii, the unit of the normalised frame."""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, Self

from ipcore.constraints.registry import Constraints
from ipcore.errors import InvalidOptionsError
from ipcore.options import choices, contradictions
from ipcore.options.choices import (
    Collinear,
    Criterion,
    Factor,
    Granularity,
    Preset,
    Ridge,
    RidgeMatrix,
)
from ipcore.options.degrees import HIGHEST_DEGREE, last_degree
from ipcore.options.derived import DerivedOptions
from ipcore.options.idle import check_acting
from ipcore.options.presets import PRESETS
from ipcore.options.ranges import RANGES, check_integer, check_number
from ipcore.polynomial.univariate import Basis

_CHOICES: dict[str, type[StrEnum]] = {
    "constraints": Constraints,
    "criterion": Criterion,
    "granularity": Granularity,
    "factor": Factor,
    "ridge": Ridge,
    "ridge_matrix": RidgeMatrix,
    "basis": Basis,
}


@dataclass(frozen=True)
class FitOptions(DerivedOptions):
    """The options of one fit. An option with named values takes the name or the member of its enumeration.

    Attributes
    ----------
    max_degree
        The last degree to try: 1 … 40 in 2D (default 20), 1 … 20 in 3D (default 16).
    constraints
        The constraint family: which equations the data give; see `Constraints`.
    layer_distance
        c, the distance of the outer layers of the 3L and 5L constraints from the data, in mean radii; 0 < c ≤ 0.3.
    gradient_weight
        μ, the weight of the squared errors of ∇f against those of f, in squared mean radii; 0 < μ ≤ 100. The default is
        2c² for c = 0.05, the weight that two layers at ±c give to ∂f/∂n near a straight line. On clean data a smaller
        weight gives a closer fit.
    criterion
        What ends the search; see `Criterion`.
    t1
        The fit is close enough when D_dist < t1, in mean radii; t1 ≥ 0. The default is the paper's, 20 % of c.
    t2
        The fit is smooth enough when D_smooth > t2; −1 ≤ t2 ≤ 1. The default is the paper's.
    granularity
        Where the search may stop: at complete degrees, or at every column.
    factor
        How the linear system is factored; see `Factor`.
    collinear
        What is done with collinear columns; by default they are ridged if `ridge` is selective, and dropped otherwise.
    collinear_tol
        A column is collinear when |r_ii|/‖c_i‖, the share of its length that is orthogonal to all earlier columns, is
        at most this.
    ridge
        Which columns ridge regression damps.
    ridge_matrix
        D, the weights of the squared coefficients of the monomials of the frame, in the damping κ aᵀDa.
    ridge_strength
        κ, the weight of the damping; 0 < κ ≤ 1e6.
    signs
        Whether the sign of f is constrained in the box, away from the data. By default, whenever `geometric` is on.
    geometric
        Whether to minimise distances and angles instead of the residuals of the linear equations (`ipcore.geometric`).
        By default on, unless an option is given that only a linear fit has: another `constraints`, `granularity` or
        `factor`, `ridge`, `collinear`, or a criterion other than distance and none.
    angle_weight
        λ, the weight of the squared differences between normals and ∇f/‖∇f‖ against the squared distances; 0 < λ ≤ 1.
        With the default both sums are equal where D_dist = 0.01 and D_smooth = 0.95.
    robust
        Whether points far from the fit are left out of the next degree's fit and of the figures that are reported.
    neighbours
        From how many neighbours a normal is estimated, if no normals are given; 3 … 100.
    basis
        The basis of the returned coefficients: monomials of the frame, or Chebyshev products on the bounds.
    measure_zero_set
        Whether to prove what can be proved of the zero set, and report its stray share and its components.

    Raises
    ------
    InvalidOptionsError
        If a value is not allowed, contradicts another, or has no effect beside the others; `at` names the option.

    """

    max_degree: int | None = None
    constraints: Constraints = Constraints.THREE_LAYER
    layer_distance: float = 0.05
    gradient_weight: float = 0.005
    criterion: Criterion = Criterion.DISTANCE
    t1: float = 0.01
    t2: float = 0.95
    granularity: Granularity = Granularity.FORM
    factor: Factor = Factor.AUTO
    collinear: Collinear | None = None
    collinear_tol: float = 1e-10
    ridge: Ridge = Ridge.NONE
    ridge_matrix: RidgeMatrix = RidgeMatrix.INVARIANT
    ridge_strength: float = 1e-4
    signs: bool | None = None
    geometric: bool | None = None
    angle_weight: float = 0.001
    robust: bool = False
    neighbours: int = 12
    basis: Basis = Basis.MONOMIAL
    measure_zero_set: bool = True

    @classmethod
    def of(cls, preset: Preset | str = Preset.DEFAULT, **given: Any) -> Self:  # noqa: ANN401 - checked one by one
        """Return the options of a preset, with the values given here in place of the preset's.

        Raises
        ------
        InvalidOptionsError
            If there is no such preset or option, or a value is not allowed.

        >>> paper = FitOptions.of("paper", max_degree=13)
        >>> str(paper.granularity), str(paper.factor), paper.max_degree
        ('monomial', 'gram-schmidt', 13)
        """
        start = PRESETS[choices.member("preset", preset, Preset)]
        names = {field.name for field in fields(cls)}
        for name in given:
            if name not in names:
                raise InvalidOptionsError(f"there is no option {name}", (name,))
        try:
            return cls(**{**start, **given})
        except InvalidOptionsError as error:
            if not set(error.at) <= start.keys() - given.keys():
                raise
            # an option of the preset has no effect beside those given, and nobody asked for it
            acting = {name: value for name, value in start.items() if name not in error.at}
            return cls(**{**acting, **given})

    def __post_init__(self) -> None:
        """Check every value that does not depend on the data, and replace names by the members that they name."""
        for name, kind in _CHOICES.items():
            object.__setattr__(self, name, choices.member(name, getattr(self, name), kind))
        if self.collinear is not None:
            object.__setattr__(self, "collinear", choices.member("collinear", self.collinear, Collinear))
        if self.max_degree is not None:
            check_integer("max_degree", self.max_degree, 1, max(HIGHEST_DEGREE.values()))
        for name, allowed in RANGES.items():
            check_number(name, getattr(self, name), allowed)
        check_integer("neighbours", self.neighbours, 3, 100)
        self._check_together()

    def _check_together(self) -> None:
        """Check the options against each other."""
        contradictions.check_least_squares(self.constraints, self.ridge, self.criterion)
        contradictions.check_collinear(self.collinear, self.ridge)
        contradictions.check_factor(self.factor, self.constraints, self.criterion, needs_rows=self.needs_rows)
        contradictions.check_linear(
            needs_linear=self.needs_linear,
            signs=self.signs,
            geometric=self.geometric,
            robust=self.robust,
            is_linear=self.is_linear,
        )
        for field in fields(self):
            if getattr(self, field.name) != field.default:
                check_acting(field.name, self.acting)

    def degree_cap(self, dimension: int) -> int:
        """Return the last degree to try on points of this dimension.

        Raises
        ------
        InvalidOptionsError
            If `max_degree` is over the highest that the dimension allows.

        """
        return last_degree(self.max_degree, dimension)

    def to_dict(self) -> dict[str, Any]:
        """Return every option by name, ready for JSON."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
