"""What a fit can be told. Every option has a default; distances are in mean radii, the unit of the normalised frame."""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, Self

from ipcore.errors import InvalidOptionsError
from ipcore.options import choices
from ipcore.options.choices import (
    Collinear,
    Constraints,
    Criterion,
    Factor,
    Granularity,
    Preset,
    Ridge,
    RidgeMatrix,
    integer,
    number,
)
from ipcore.polynomial.univariate import Basis

DEFAULT_MAX_DEGREE = {2: 20, 3: 16}
HIGHEST_DEGREE = {2: 40, 3: 20}

# Families that ask for nothing but values of f, the same whatever the degree; and those whose right-hand side, or
# whatever takes its place, changes with it.
LAYERED = {Constraints.THREE_LAYER, Constraints.FIVE_LAYER}
CHANGING = {Constraints.MIN_MAX, Constraints.MIN_VAR, Constraints.TAUBIN}

_CHOICES: dict[str, type[StrEnum]] = {
    "constraints": Constraints,
    "criterion": Criterion,
    "granularity": Granularity,
    "factor": Factor,
    "ridge": Ridge,
    "ridge_matrix": RidgeMatrix,
    "basis": Basis,
}
# κ = 1e-10 moves no fit visibly and still bounds the condition: on three outlines the same column was chosen for every
# κ from 1e-14 to 1e-4.
_PRESETS: dict[Preset, dict[str, Any]] = {
    Preset.DEFAULT: {},
    Preset.PAPER: {
        "granularity": Granularity.MONOMIAL,
        "factor": Factor.GRAM_SCHMIDT,
        "ridge": Ridge.FULL,
        "ridge_strength": 1e-10,
    },
}


@dataclass(frozen=True)
class FitOptions:
    """The options of one fit. Those with named values take the name or the member of the enumeration.

    Attributes
    ----------
    max_degree
        The last degree to try: 1 … 40 in 2D (default 20), 1 … 20 in 3D (default 16).
    constraints
        Which equations the data give; see `Constraints`.
    layer_distance
        c, the distance of the outer layers of the 3L and 5L constraints from the data, in mean radii; 0 < c ≤ 0.3.
    gradient_weight
        μ, the weight of the squared errors of ∇f against those of f, in squared mean radii; 0 < μ ≤ 100. The default is
        2c² for c = 0.05: near a straight line two layers at ±c weigh ∂f/∂n so. On clean data less is closer.
    criterion
        What ends the search; see `Criterion`.
    t1
        The fit is close enough when D_dist < t1, in mean radii. The paper takes 20 % of c.
    t2
        The fit is smooth enough when D_smooth > t2; −1 … 1.
    granularity
        Where the search may stop: at complete degrees, or at every column.
    factor
        How the linear system is factored; see `Factor`.
    collinear
        What becomes of collinear columns. By default they are ridged if `ridge` is selective, and dropped if it is not.
    collinear_tol
        A column is collinear when the part of it that no earlier column explains, |r_ii|/‖c_i‖, is at most this.
    ridge
        Which columns ridge regression damps.
    ridge_matrix
        D, the weights of the squared coefficients, of the monomials of the frame.
    ridge_strength
        κ, the weight of the damping; 0 < κ ≤ 1e6.
    signs
        Whether f is told its sign in the box away from the data. By default it is whenever `geometric` is on.
    geometric
        Whether to minimise distances and angles instead of the linear equations' errors (`ipcore.geometric`). By
        default on, unless an option is given that only a linear fit has: another `constraints`,
        `granularity` or `factor`, `ridge`, `collinear`, or a criterion other than distance and none.
    angle_weight
        λ, the weight of squared differences between normals and ∇f/‖∇f‖ against squared distances; 0 < λ ≤ 1. At the
        default both count the same where D_dist = 0.01 and D_smooth = 0.95.
    robust
        Whether points that lie far from the fit are left out, of the fit and of what is reported of it.
    neighbours
        How many neighbours estimate a normal, when none are given; at least 3.
    basis
        What the answer's coefficients multiply: monomials of the frame, or Chebyshev products on the bounds.
    measure_zero_set
        Whether to extract the zero set once, coarsely, and report its stray share and its components.

    Raises
    ------
    InvalidOptionsError
        If a value is not allowed, or contradicts another; `at` names the option.

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
        """Return a preset's options with those given in their place.

        Raises
        ------
        InvalidOptionsError
            If there is no such preset or option, or a value is not allowed.

        >>> paper = FitOptions.of("paper", max_degree=13)
        >>> str(paper.granularity), str(paper.factor), paper.max_degree
        ('monomial', 'gram-schmidt', 13)
        """
        start = _PRESETS[choices.chosen("preset", preset, Preset)]
        names = {field.name for field in fields(cls)}
        for name in given:
            if name not in names:
                raise InvalidOptionsError(f"there is no option {name}", (name,))
        return cls(**{**start, **given})

    def __post_init__(self) -> None:
        """Check every value that does not depend on the data, and take names as members."""
        for name, kind in _CHOICES.items():
            object.__setattr__(self, name, choices.chosen(name, getattr(self, name), kind))
        if self.collinear is not None:
            object.__setattr__(self, "collinear", choices.chosen("collinear", self.collinear, Collinear))
        if self.max_degree is not None:
            integer("max_degree", self.max_degree, 1, max(HIGHEST_DEGREE.values()))
        number("layer_distance", self.layer_distance, 0.0, 0.3, open_below=True)
        number("gradient_weight", self.gradient_weight, 0.0, 100.0, open_below=True)
        number("t1", self.t1, 0.0, float("inf"))
        number("t2", self.t2, -1.0, 1.0)
        number("collinear_tol", self.collinear_tol, 0.0, 1.0)
        number("ridge_strength", self.ridge_strength, 0.0, 1e6, open_below=True)
        number("angle_weight", self.angle_weight, 0.0, 1.0, open_below=True)
        integer("neighbours", self.neighbours, 3, 100)
        self._check_together()

    def _check_together(self) -> None:
        """Refuse what contradicts itself."""
        if self.constraints is Constraints.TAUBIN and self.ridge is not Ridge.NONE:
            raise InvalidOptionsError("ridge needs a right-hand side, and taubin has none", ("ridge",))
        if self.constraints is Constraints.TAUBIN and self.criterion not in {Criterion.DISTANCE, Criterion.NONE}:
            raise InvalidOptionsError(
                f"criterion {self.criterion} needs a least-squares fit, and taubin is an eigenvector", ("criterion",)
            )
        if self.collinear is not None and (self.collinear is Collinear.RIDGE) != (self.ridge is Ridge.SELECTIVE):
            raise InvalidOptionsError(
                f"collinear is ridge exactly when ridge is selective, not {self.collinear} with ridge {self.ridge}",
                ("collinear",),
            )

        self._check_factor()
        if self._asks_for_linear and (self.signs or self.geometric):
            name = "geometric" if self.geometric else "signs"
            raise InvalidOptionsError(
                f"{name} goes with 3l constraints, complete forms, no ridge, and the criterion distance or none",
                (name,),
            )
        if self.robust and self.is_linear:
            raise InvalidOptionsError("robust needs the geometric fit, or that under sign constraints", ("robust",))

    def _check_factor(self) -> None:
        """Refuse a factorisation that cannot do what else is asked for."""
        if self.factor not in {Factor.MOMENTS, Factor.TSQR}:
            return
        if self.needs_rows:
            what = "criterion loo" if self.criterion is Criterion.LOO else f"constraints {self.constraints}"
            raise InvalidOptionsError(f"{what} needs the rows that factor {self.factor} does not keep", ("factor",))
        if self.factor is Factor.MOMENTS and self.constraints not in LAYERED:
            raise InvalidOptionsError(
                f"factor moments is for constraints 3l and 5l, not {self.constraints}; take tsqr", ("factor",)
            )

    @property
    def needs_rows(self) -> bool:
        """Return whether the fit needs all rows at hand: to leave points out, or because b changes with the degree."""
        return self.criterion is Criterion.LOO or self.constraints in CHANGING

    @property
    def _asks_for_linear(self) -> bool:
        """Whether something was chosen that only a linear fit has."""
        return (
            self.constraints is not Constraints.THREE_LAYER
            or self.granularity is not Granularity.FORM
            or self.factor is not Factor.AUTO
            or self.ridge is not Ridge.NONE
            or self.collinear is not None
            or self.criterion not in {Criterion.DISTANCE, Criterion.NONE}
        )

    @property
    def on_geometric(self) -> bool:
        """Return whether distances and angles are minimised, the default filled in."""
        return not self._asks_for_linear if self.geometric is None else self.geometric

    @property
    def on_signs(self) -> bool:
        """Return whether signs are constrained, the default filled in."""
        return self.on_geometric if self.signs is None else self.signs

    @property
    def is_linear(self) -> bool:
        """Return whether the fit is the solution of linear equations."""
        return not (self.on_geometric or self.on_signs)

    @property
    def on_collinear(self) -> Collinear:
        """Return what becomes of collinear columns, the default filled in."""
        if self.collinear is not None:
            return self.collinear
        return Collinear.RIDGE if self.ridge is Ridge.SELECTIVE else Collinear.DROP

    def degree_cap(self, dimension: int) -> int:
        """Return the last degree to try on points of this dimension.

        Raises
        ------
        InvalidOptionsError
            If `max_degree` is over the highest that the dimension allows.

        """
        cap = DEFAULT_MAX_DEGREE[dimension] if self.max_degree is None else self.max_degree
        if cap > HIGHEST_DEGREE[dimension]:
            highest = HIGHEST_DEGREE[dimension]
            raise InvalidOptionsError(
                f"max_degree must be at most {highest} for {dimension}D points, not {cap}", ("max_degree",)
            )
        return cap

    def to_dict(self) -> dict[str, Any]:
        """Return every option by name, ready for JSON."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
