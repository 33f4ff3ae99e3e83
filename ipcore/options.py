"""What a fit can be told. Every option has a default; distances are in mean radii, the unit of the normalised frame."""

from dataclasses import dataclass, fields
from numbers import Integral
from typing import Any

from ipcore.basis import Basis
from ipcore.errors import InvalidOptionsError

DEFAULT_MAX_DEGREE = {2: 20, 3: 16}
HIGHEST_DEGREE = {2: 40, 3: 20}


@dataclass(frozen=True)
class FitOptions:
    """The options of one fit.

    Attributes
    ----------
    max_degree
        The last degree to try: 1 … 40 in 2D (default 20), 1 … 20 in 3D (default 16).
    layer_distance
        c, the distance of the two outer layers of the 3L constraints from the data, in mean radii; 0 < c ≤ 0.3.
    t1
        The fit is close enough when D_dist < t1, in mean radii. The paper takes 20 % of c.
    t2
        The fit is smooth enough when D_smooth > t2; −1 … 1.
    collinear_tol
        A column is dropped when the part of it that no earlier column explains, |r_ii|/‖c_i‖, is at most this.
    neighbours
        How many neighbours estimate a normal, when none are given; at least 3.
    basis
        What the answer's coefficients multiply: monomials of the frame, or Chebyshev products on the bounds.
    measure_zero_set
        Whether to extract the zero set once, coarsely, and report its stray share and its components.

    Raises
    ------
    InvalidOptionsError
        If a value is not allowed; `at` names the option.

    """

    max_degree: int | None = None
    layer_distance: float = 0.05
    t1: float = 0.01
    t2: float = 0.95
    collinear_tol: float = 1e-10
    neighbours: int = 12
    basis: Basis = Basis.MONOMIAL
    measure_zero_set: bool = True

    def __post_init__(self) -> None:
        """Check every value that does not depend on the data."""
        if self.max_degree is not None:
            _integer("max_degree", self.max_degree, 1, max(HIGHEST_DEGREE.values()))
        _number("layer_distance", self.layer_distance, 0.0, 0.3, open_below=True)
        _number("t1", self.t1, 0.0, float("inf"))
        _number("t2", self.t2, -1.0, 1.0)
        _number("collinear_tol", self.collinear_tol, 0.0, 1.0)
        _integer("neighbours", self.neighbours, 3, 100)
        if self.basis not in tuple(Basis):
            raise InvalidOptionsError(f"basis must be monomial or chebyshev, not {self.basis!r}", ("basis",))

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


def _integer(name: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, Integral) or not low <= int(value) <= high:
        raise InvalidOptionsError(f"{name} must be an integer from {low} to {high}, not {value!r}", (name,))


def _number(name: str, value: object, low: float, high: float, *, open_below: bool = False) -> None:
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not low <= value <= high
        or (open_below and value == low)
    ):
        bracket = "more than" if open_below else "at least"
        raise InvalidOptionsError(f"{name} must be a number {bracket} {low} and at most {high}, not {value!r}", (name,))
