r"""What a constraint family yields: rows of M a = b, one per point in every group.

A row asks for f itself or for one partial derivative, at a position that belongs to a data point:

    w f(p) = w b    or    w ∂_k f(p) = w b

The rows stand group by group, and in each group in the order of the points, so row i belongs to point i mod N. An
equation for the whole gradient is written as its d partial derivatives. Any other orthonormal directions, such as the
normal and the tangents of the literature, give the same sum of squares: Σ_t (t·(∇f − g))² = ‖∇f − g‖².
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipcore._typing import FloatArray


@dataclass(frozen=True, eq=False)
class RowGroup:
    """One row per point.

    Attributes
    ----------
    positions
        (N, d), in the normalised frame.
    b
        (N,), what is asked for, before it is weighted.
    axis
        k of ∂_k f; None asks for f itself.
    weight
        w, by which row and right-hand side are multiplied.

    """

    positions: FloatArray
    b: FloatArray
    axis: int | None = None
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class Rows:
    """All rows of a family.

    Attributes
    ----------
    groups
        In the order in which they stand in M.
    gradient_length
        Gives, for a degree, by how much the right-hand sides of the derivatives are multiplied at each point, (N,):
        for families that ask for another ‖∇f‖ at every degree. M does not depend on it.

    """

    groups: tuple[RowGroup, ...]
    gradient_length: Callable[[int], FloatArray] | None = None

    def b(self, degree: int) -> FloatArray:
        """Return the right-hand side (groups · N,) for a fit of this degree."""
        length = np.float64(1.0) if self.gradient_length is None else self.gradient_length(degree)
        return np.concatenate(
            [group.weight * group.b * (1.0 if group.axis is None else length) for group in self.groups]
        )


def layers(points: FloatArray, normals: FloatArray, offsets: tuple[float, ...]) -> tuple[RowGroup, ...]:
    """Return rows f(x_i + o n_i) = o, one group per offset o."""
    return tuple(RowGroup(points + o * normals, np.full(len(points), o)) for o in offsets)


def gradients(points: FloatArray, target: FloatArray, weight: float) -> tuple[RowGroup, ...]:
    """Return rows ∂_k f(x_i) = target_ik, one group per axis; `weight` is that of the squared error."""
    return tuple(RowGroup(points, target[:, k], k, np.sqrt(weight)) for k in range(points.shape[1]))
