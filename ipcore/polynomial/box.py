"""The affine map between a box and the cube [−1, 1]^d, axis by axis: where Chebyshev products are defined."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import FloatArray


@dataclass(frozen=True, eq=False)
class Box:
    """A box by its middle m and half lengths h: t = (x − m)/h takes it to the cube [−1, 1]^d.

    Attributes
    ----------
    middle
        (d,), the centre of the box, in the frame of its bounds.
    half
        (d,), half of its length along each axis, positive.

    Examples
    --------
    >>> box = Box.of(np.array([[0.0, -2.0], [4.0, 2.0]]))
    >>> box.to_cube(np.array([[4.0, 1.0]])).tolist(), box.from_cube(np.array([[1.0, 0.5]])).tolist()
    ([[1.0, 0.5]], [[4.0, 1.0]])

    """

    middle: FloatArray
    half: FloatArray

    @classmethod
    def of(cls, bounds: FloatArray) -> Self:
        """Return the box with the lower and the upper corner `bounds` (2, d)."""
        lower, upper = bounds
        return cls((lower + upper) / 2.0, (upper - lower) / 2.0)

    def to_cube(self, x: FloatArray) -> FloatArray:
        """Return t = (x − m)/h of points x (…, d), in their shape."""
        return np.asarray((x - self.middle) / self.half)

    def from_cube(self, t: FloatArray) -> FloatArray:
        """Return x = m + h t of points t (…, d) in the cube, in their shape."""
        return np.asarray(self.middle + self.half * t)

    def axis_to_cube(self, x: FloatArray, axis: int) -> FloatArray:
        """Return t of coordinates x along one axis, of any shape, in their shape."""
        return np.asarray((x - self.middle[axis]) / self.half[axis])

    def axis_from_cube(self, t: FloatArray, axis: int) -> FloatArray:
        """Return x of coordinates t along one axis of the cube, of any shape, in their shape."""
        return np.asarray(self.middle[axis] + self.half[axis] * t)
