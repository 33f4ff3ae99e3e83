"""Checks a proof by other means than those that found it: on boxes, in the ball arithmetic of Arb (python-flint).

All numbers of f are balls that hold the exact values, so no rounding has to be estimated. On a box f lies between the
least and the greatest of its Bernstein coefficients there, and these are computed for each box afresh from the
coefficients of the answer. Nothing of `ipcore` is used.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product
from math import comb

import numpy as np
from flint import arb, arb_mat, arb_poly, ctx, fmpq, fmpq_mat
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from service.cli.claimed import Polynomial

BITS = 128
FIRST_HALVINGS = 3  # of the bounds, along every axis
MOST_HALVINGS = 14
PLACES_OFF = 1e-9  # of places and distances, which are doubles: a share of them that is far larger
FloatArray = NDArray[np.float64]


class UnverifiedError(Exception):
    """Something could not be verified; the message says what, and where."""


@dataclass(frozen=True)
class Box:
    """One of the 2^halvings parts along each axis of the bounds."""

    halvings: int
    place: tuple[int, ...]

    def parts(self) -> Iterator["Box"]:
        """Yield the halves along every axis."""
        for steps in product((0, 1), repeat=len(self.place)):
            yield Box(self.halvings + 1, tuple(2 * k + step for k, step in zip(self.place, steps, strict=True)))


class Function:
    """A polynomial as it stands in an answer, on boxes of its bounds."""

    def __init__(self, polynomial: Polynomial) -> None:
        """Take the polynomial of an answer."""
        ctx.prec = BITS
        self._degree, self._frame = polynomial.degree, polynomial.frame
        self._chebyshev = polynomial.basis == "chebyshev"
        self.bounds = np.array(polynomial.bounds, dtype=float)
        self.dimension = self.bounds.shape[1]
        count = self._degree + 1
        tensor = np.zeros((count,) * self.dimension)
        for exponents, a in zip(polynomial.exponents, polynomial.coefficients, strict=True):
            tensor[tuple(exponents)] = a
        self._tensor = arb_mat([[arb(a) for a in rows] for rows in tensor.reshape(count, -1).tolist()])
        weights = [[fmpq(comb(j, i), comb(count - 1, i)) for i in range(count)] for j in range(count)]
        self._to_bernstein = arb_mat(fmpq_mat(weights))
        self._along = lru_cache(maxsize=4096)(self._functions)
        self._layers = lru_cache(maxsize=64)(self._contracted)

    def sign(self, box: Box, derivative: int | None = None) -> int:
        """Return the sign of f, or of its derivative along an axis, on a whole box; 0 if it may have two."""
        _, *others = (self._along(k, box.halvings, at, derived=k == derivative) for k, at in enumerate(box.place))
        sign = 0
        for layer in self._layers(box.halvings, box.place[0], derived=derivative == 0):
            b = others[0] * layer
            if self.dimension == 3:
                b *= others[1].transpose()
            found = _common_sign(b.entries())
            if found in {0, -sign}:
                return 0
            sign = found
        return sign

    def _contracted(self, halvings: int, at: int, *, derived: bool) -> list[arb_mat]:
        """Return what is left of the coefficients on an interval of the first variable, a matrix for each function."""
        left, count = self._along(0, halvings, at, derived=derived) * self._tensor, self._degree + 1
        return [arb_mat(count, left.ncols() // count, row) for row in left.table()]

    def _functions(self, axis: int, halvings: int, at: int, *, derived: bool) -> arb_mat:
        """Return the matrix that maps coefficients along an axis to Bernstein coefficients on an interval.

        Or to their differences, which have the signs of those of the derivative.
        """
        low, high = (arb(bound) for bound in self.bounds[:, axis].tolist())
        length = (high - low) / 2**halvings
        if self._chebyshev:
            u = arb_poly([arb(at) / 2 ** (halvings - 1) - 1, arb(1) / 2 ** (halvings - 1)])
        else:
            centre, scale = arb(self._frame.centre[axis]), arb(self._frame.scale)
            u = arb_poly([(low + length * at - centre) / scale, length / scale])
        functions = [arb_poly([1]), u]
        while len(functions) <= self._degree:
            functions.append(2 * u * functions[-1] - functions[-2] if self._chebyshev else u * functions[-1])
        powers = range(self._degree + 1)
        b = self._to_bernstein * arb_mat([[f[i] for f in functions[: self._degree + 1]] for i in powers])
        if not derived:
            return b
        rows = b.table()
        return arb_mat([[y - x for x, y in zip(*pair, strict=True)] for pair in pairwise(rows)])


def _common_sign(values: list[arb]) -> int:
    """Return the sign that all balls have, or 0."""
    if values[0] > 0:
        return 1 if all(value > 0 for value in values) else 0
    return -1 if all(value < 0 for value in values) else 0


class Claims:
    """What an answer claims of its zero set, to be verified on boxes that are halved."""

    def __init__(self, polynomial: Polynomial, points: FloatArray, within: float) -> None:
        """Take the polynomial of an answer, the points that were fitted (N, d), and `within` of the proof."""
        self._function, self._tree, self._within = Function(polynomial), cKDTree(points), within
        first = product(range(2**FIRST_HALVINGS), repeat=self._function.dimension)
        self._near, self._first = list[Box](), [Box(FIRST_HALVINGS, place) for place in first]

    def verify_within(self) -> int:
        """Verify that every zero in the bounds has a point within the distance; return the number of boxes.

        Raises
        ------
        UnverifiedError
            If that could not be verified.

        """

        def settled(box: Box) -> bool:
            if self._is_near(box):
                self._near.append(box)
                return True
            return self._function.sign(box) != 0

        return self._walk(self._first, settled, "there may be a zero too far from all points")

    def verify_regular(self) -> int:
        """Verify that ∇f vanishes at no zero, in the boxes near the points; return the number of boxes.

        Raises
        ------
        UnverifiedError
            If that could not be verified.

        """

        def settled(box: Box) -> bool:
            signs = (self._function.sign(box, axis) for axis in (None, *range(self._function.dimension)))
            return any(sign != 0 for sign in signs)

        return self._walk(self._near, settled, "the zero set may not be smooth")

    def _walk(self, first: Iterable[Box], settled: Callable[[Box], bool], otherwise: str) -> int:
        """Halve boxes until something is settled on each of them; return how many there were."""
        waiting, count = list(first), 0
        while waiting:
            box = waiting.pop()
            count += 1
            if settled(box):
                continue
            if box.halvings == MOST_HALVINGS:
                place = ", ".join(f"{x:.6g}" for x in self._middle(box))
                raise UnverifiedError(f"{otherwise}, at ({place})")
            waiting += box.parts()
        return count

    def _is_near(self, box: Box) -> bool:
        """Return whether each place of a box is within the distance of one point."""
        low, high = self._function.bounds
        radius = float(np.linalg.norm(high - low)) / 2 ** (box.halvings + 1)
        middle = self._middle(box)
        rounding = PLACES_OFF * (radius + float(np.abs(self._function.bounds).max()) * 1e-5)
        return bool(float(self._tree.query(middle)[0]) + radius + rounding <= self._within)

    def _middle(self, box: Box) -> FloatArray:
        """Return the middle of a box, (d,)."""
        low, high = self._function.bounds
        return np.asarray(low + (high - low) * (np.array(box.place) + 0.5) / 2**box.halvings)
