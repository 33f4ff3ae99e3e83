"""The implicit polynomial f(x) = 0, in the caller's coordinates."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from ipcore._typing import BoolArray, ExtendedArray, FloatArray, IntArray
from ipcore.errors import InvalidPointsError, InvalidPolynomialError
from ipcore.polynomial import evaluation, graded, plain, univariate
from ipcore.polynomial.box import Box
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.univariate import Basis


@dataclass(frozen=True, eq=False)
class ImplicitPolynomial:
    """A polynomial whose zero set is the curve or surface, negative inside.

    In the monomial basis f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ. In the Chebyshev basis the power
    u^e is replaced by T_e(t) along each axis, with t running from −1 to 1 over `bounds`.

    Attributes
    ----------
    degree
        The total degree n.
    coefficients
        (m,), in the order of `exponents`; without unit: f measures in mean radii where ‖∇f‖ is 1 per mean radius.
    frame
        Its centre (d,) and scale, in raw units.
    bounds
        (2, d), lower and upper corner, raw: the box in which the fit was made. Outside of it f is not to be trusted.
    basis
        The functions that the coefficients multiply.

    Examples
    --------
    The circle of radius 2 about the origin:

    >>> frame = Frame(np.zeros(2), 1.0)
    >>> box = np.array([[-3.0, -3.0], [3.0, 3.0]])
    >>> circle = ImplicitPolynomial(2, np.array([-4.0, 0, 0, 1, 0, 1]), frame, box)
    >>> circle(np.array([[0.0, 0.0], [2.0, 0.0], [3.0, 0.0]])).tolist()
    [-4.0, 0.0, 5.0]
    >>> circle.distance(np.array([[3.0, 0.0]])).tolist()           # f/‖∇f‖ = 5/6; the true distance is 1
    [0.8333333333333334]

    """

    degree: int
    coefficients: FloatArray
    frame: Frame
    bounds: FloatArray
    basis: Basis = Basis.MONOMIAL

    def __post_init__(self) -> None:
        """Raise if the parts do not fit together.

        Raises
        ------
        InvalidPolynomialError
            If the number of coefficients is not that of the degree, or a number is not finite, or the box is empty.

        """
        m, d = graded.count(self.dimension, self.degree), self.dimension
        if self.coefficients.shape != (m,):
            given = len(self.coefficients)
            raise InvalidPolynomialError(
                f"degree {self.degree} in {d} variables has {m} coefficients, not {given}", ("coefficients",)
            )
        if self.bounds.shape != (2, d) or not np.all(self.bounds[0] < self.bounds[1]):
            raise InvalidPolynomialError(f"bounds must be a lower and an upper corner of {d} coordinates", ("bounds",))
        if not (np.isfinite(self.coefficients).all() and np.isfinite(self.bounds).all() and self.frame.scale > 0):
            raise InvalidPolynomialError("coefficients and bounds must be finite and the scale positive")

    @property
    def dimension(self) -> int:
        """Return d, 2 or 3."""
        return len(self.frame.centre)

    @property
    def exponents(self) -> IntArray:
        """Return the exponents (m, d), in graded order."""
        return graded.exponents(self.dimension, self.degree)

    def __call__(self, x: FloatArray) -> FloatArray:
        """Return f at raw points x (M, d), shape (M,)."""
        values: FloatArray = evaluation.scattered(self.tensor[None], self._tables(x))[0]
        return values

    def gradient(self, x: FloatArray) -> FloatArray:
        """Return ∇f at raw points x (M, d), shape (M, d), per raw unit of length."""
        return evaluation.scattered(self._derivatives[1:], self._tables(x)).T

    def value_and_gradient(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return f (M,) and ∇f (M, d) at raw points x (M, d), in little more time than one of them takes."""
        both = evaluation.scattered(self._derivatives, self._tables(x))
        return both[0], both[1:].T

    def hessian(self, x: FloatArray) -> FloatArray:
        """Return the matrices of second derivatives at raw points x (M, d), shape (M, d, d)."""
        d = self.dimension
        pairs = [(row, column) for row in range(d) for column in range(row, d)]
        second = np.stack([self._differentiate(self._derivatives[1 + row], column) for row, column in pairs])
        out = np.empty((len(x), d, d))
        for (row, column), values in zip(pairs, evaluation.scattered(second, self._tables(x)), strict=True):
            out[:, row, column] = out[:, column, row] = values
        return out

    def distance(self, x: FloatArray) -> FloatArray:
        """Return the first-order signed distance f/‖∇f‖ (Taubin 1991) at raw points x (M, d), raw units, shape (M,).

        Exact to second order near the zero set; far from it only the sign is to be trusted. Where ∇f vanishes it is
        infinite, or 0 if f vanishes too.
        """
        f, gradient = self.value_and_gradient(x)
        size = np.linalg.norm(gradient, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(f == 0.0, 0.0, f / size))

    def on_grid(self, axes: list[FloatArray]) -> FloatArray:
        """Return f on the tensor grid of raw grid lines, one array per axis, shape (len(axes[0]), …)."""
        return evaluation.along_axes(self.tensor, self.tables(axes))

    def tables(self, axes: list[FloatArray]) -> list[FloatArray]:
        """Return the univariate functions at raw grid lines (N_axis,), (N_axis, n+1) for each axis.

        `tensor` times these, along each axis, is f on the grid.
        """
        variables = [self.variable(lines, axis) for axis, lines in enumerate(axes)]
        return [univariate.table(self.basis, t, self.degree).T for t in variables]

    def variable(self, coordinates: FloatArray, axis: int) -> FloatArray:
        """Return the variable of the univariate functions at raw coordinates along one axis, in their shape."""
        return self._box.axis_to_cube(coordinates, axis)

    def contains(self, x: FloatArray) -> BoolArray:
        """Return which raw points x (M, d) lie in the bounds, (M,); elsewhere f is not to be trusted."""
        x = self._checked(x)
        return np.asarray(((x >= self.bounds[0]) & (x <= self.bounds[1])).all(axis=1))

    def to_monomial(self) -> Self:
        """Return the same polynomial in the monomial basis of the frame.

        The change of basis is computed in extended precision. What remains is the rounding of the coefficients, the
        effect of which on f grows with the degree in the monomial basis.
        """
        if self.basis is Basis.MONOMIAL:
            return self
        return self._changed(univariate.chebyshev_to_powers, Basis.MONOMIAL)

    def to_chebyshev(self) -> Self:
        """Return the same polynomial in the Chebyshev basis of the bounds, computed as in `to_monomial`."""
        if self.basis is Basis.CHEBYSHEV:
            return self
        return self._changed(univariate.powers_to_chebyshev, Basis.CHEBYSHEV)

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists and numbers, ready for JSON; `from_dict` reads them back bit for bit."""
        return plain.write(self.degree, self.coefficients, self.frame, self.bounds, self.basis)

    @classmethod
    def from_dict(cls, parts: dict[str, Any]) -> Self:
        """Read what `to_dict` wrote. Exponents may stand in any order, and missing ones mean zero.

        Raises
        ------
        InvalidPolynomialError
            If a part is missing or the parts do not fit together.

        """
        return cls(*plain.read(parts))

    def _changed(self, change: Callable[[int, float, float], ExtendedArray], basis: Basis) -> Self:
        """Return the polynomial in the other basis.

        `change` gives the matrix (n+1, n+1) along one axis for the map t = slope·u + offset from the frame to the cube.
        """
        box = Box.of(self.bounds)
        slopes, offsets = self.frame.scale / box.half, box.to_cube(self.frame.centre)
        matrices = [change(self.degree, *line) for line in zip(slopes, offsets, strict=True)]
        tensor = evaluation.along_axes(self.tensor.astype(np.longdouble), matrices)
        a = evaluation.from_tensor(tensor, self.dimension, self.degree).astype(np.float64)
        return type(self)(self.degree, a, self.frame, self.bounds, basis)

    @cached_property
    def tensor(self) -> FloatArray:
        """Return the coefficients as a tensor (n+1, …), one axis per variable, zero beyond total degree n."""
        return evaluation.to_tensor(self.coefficients, self.dimension, self.degree)

    @cached_property
    def _derivatives(self) -> FloatArray:
        """The tensors of f and of its first derivatives, (1 + d, n+1, …)."""
        first = [self._differentiate(self.tensor, axis) for axis in range(self.dimension)]
        return np.stack([self.tensor, *first])

    @cached_property
    def _box(self) -> Box:
        """The box whose coordinates t in the cube are the variables of the univariate functions."""
        if self.basis is Basis.MONOMIAL:
            return Box(self.frame.centre, np.full(self.dimension, self.frame.scale))
        return Box.of(self.bounds)

    def _differentiate(self, tensor: FloatArray, axis: int) -> FloatArray:
        """Return the tensor (n+1, …) of the derivative along an axis of the polynomial with a tensor (n+1, …)."""
        D = univariate.differentiation(self.basis, self.degree) / self._box.half[axis]
        rows = tensor.reshape(len(D) ** axis, len(D), -1)  # the axes before it, it, and those behind
        return np.asarray(np.matmul(D, rows).reshape(tensor.shape))

    def _tables(self, x: FloatArray) -> list[FloatArray]:
        """Return the univariate functions at raw points x (M, d), (n+1, M) for each axis."""
        x = self._checked(x)
        return [table.T for table in self.tables([np.ascontiguousarray(column) for column in x.T])]

    def _checked(self, x: FloatArray) -> FloatArray:
        """Return points x as doubles (M, d), or raise."""
        x = np.asarray(x, dtype=np.float64)
        if x.ndim != 2 or x.shape[1] != self.dimension:
            raise InvalidPointsError(f"points must have shape (M, {self.dimension}), not {x.shape}", ("points",))
        return x


def values_and_gradients(
    polynomials: Sequence[ImplicitPolynomial], x: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """Return f (M,) and ∇f (M, d) of several polynomials at raw points x (M, d), as `value_and_gradient` each.

    They must have frame, bounds and basis in common; then they share the tables and products of the variables.
    """
    highest = max(polynomials, key=lambda polynomial: polynomial.degree)
    evaluated = evaluation.scattered_stacks([p._derivatives for p in polynomials], highest._tables(x))  # noqa: SLF001 - of this module
    return [(both[0], both[1:].T) for both in evaluated]
