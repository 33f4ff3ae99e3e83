r"""The rows of M a = b that a constraint family makes of N points: groups of N rows, one row per point in each group.

A row states a value of f itself or of one partial derivative, at a position p that belongs to a data point:

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
    """N rows, one per point, all of the same kind.

    Attributes
    ----------
    positions
        (N, d), where f or its derivative is taken, in the normalised frame.
    b
        (N,), the value that the row states, before it is multiplied by the weight.
    axis
        k of ∂_k f; None if the row states a value of f itself.
    weight
        w, the factor of both sides of the row.

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
        The groups of rows, in the order in which they stand in M.
    gradient_length
        A function from the degree of the fit to factors (N,), one per point, by which the right-hand sides of the
        derivative rows are multiplied; None if they do not depend on the degree. M never depends on it.

    """

    groups: tuple[RowGroup, ...]
    gradient_length: Callable[[int], FloatArray] | None = None

    def b(self, degree: int) -> FloatArray:
        """Return the right-hand side (groups · N,) for a fit of this degree."""
        length = np.float64(1.0) if self.gradient_length is None else self.gradient_length(degree)
        return np.concatenate(
            [group.weight * group.b * (1.0 if group.axis is None else length) for group in self.groups]
        )


def layer_rows(points: FloatArray, normals: FloatArray, offsets: tuple[float, ...]) -> tuple[RowGroup, ...]:
    """Return the rows f(x_i + o n_i) = o, one group per offset o; points and normals (N, d), offsets in mean radii."""
    return tuple(RowGroup(points + o * normals, np.full(len(points), o)) for o in offsets)


def gradient_rows(points: FloatArray, gradients: FloatArray, weight: float) -> tuple[RowGroup, ...]:
    """Return the rows √μ ∂_k f(x_i) = √μ g_ik, one group per axis k; points and g (N, d), `weight` μ."""
    return tuple(RowGroup(points, gradients[:, k], k, np.sqrt(weight)) for k in range(points.shape[1]))
