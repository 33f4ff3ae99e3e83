"""The evaluation of f = Σ a_ijk X_i(x) Y_j(y) Z_k(z), by matrix products in place of sums term by term."""

from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from ipcore._typing import ExtendedArray, FloatArray
from ipcore.polynomial import graded

Array = TypeVar("Array", FloatArray, ExtendedArray)

DEGREES_TOGETHER = 2  # of the last of three variables, in one matrix product: with more, more of its factor are zeros
CHUNK_POINTS = 4096  # for which products and sums are formed together: 5 MB for a surface of degree 12 and its gradient


def to_tensor(coefficients: Array, dimension: int, degree: int) -> Array:
    """Return coefficients in graded order (…, m) as a tensor (…, n+1, …, n+1), zero beyond total degree n."""
    tensor = np.zeros((*coefficients.shape[:-1], *(degree + 1,) * dimension), dtype=coefficients.dtype)
    tensor[(..., *graded.exponents(dimension, degree).T)] = coefficients
    return tensor


def from_tensor(tensor: Array, dimension: int, degree: int) -> Array:
    """Return the coefficients (…, m) of a tensor (…, n+1, …, n+1) in graded order: the inverse of `to_tensor`."""
    return tensor[(..., *graded.exponents(dimension, degree).T)]


def along_axes(tensor: Array, matrices: list[Array]) -> Array:
    """Return a tensor (n+1, …) multiplied along each axis by a matrix (N_axis, n+1), shape (N_x, N_y[, N_z]).

    out_abc = Σ_ijk A_ai B_bj C_ck tensor_ijk. With the univariate values at grid lines for matrices, this evaluates on
    the grid, in O(n · N^d).
    """
    for matrix in matrices:  # the contracted axis goes last, so after d steps the axes stand in order again
        rest = tensor.shape[1:]
        tensor = (tensor.reshape(len(tensor), -1).T @ matrix.T).reshape(
            *rest, len(matrix)
        )  # as np.tensordot, but faster
    return tensor


def scattered(tensors: FloatArray, tables: list[FloatArray]) -> FloatArray:
    """Return the values of p polynomials of one degree at the same N points.

    Parameters
    ----------
    tensors
        (p, n+1, …, n+1), coefficients, zero beyond total degree n.
    tables
        For each variable its univariate functions at the points, (≥ n+1, N).

    Returns
    -------
        (p, N)

    """
    return scattered_stacks([tensors], tables)[0]


def scattered_stacks(stacks: list[FloatArray], tables: list[FloatArray]) -> list[FloatArray]:
    """Return what `scattered` returns for each of several stacks of polynomials, which may differ in degree.

    The products of the first d − 1 variables are formed once. They are multiplied by the coefficients, in matrix
    products, and the results summed over the last variable's functions. The function of degree k occurs only with a
    prefix of the products, those of degree ≤ n − k. In 3D a few k are taken together, so that most zeros are left out;
    that takes about p n³/4 multiplications per point in BLAS-3.
    """
    top, N = max(len(stack[0]) for stack in stacks) - 1, tables[0].shape[1]
    forms = [_GroupedCoefficients.of(stack) for stack in stacks]
    outs = [np.empty((len(stack), N)) for stack in stacks]
    scratch = np.empty((graded.count(len(tables) - 1, top), min(CHUNK_POINTS, N)))
    for start in range(0, N, CHUNK_POINTS):
        part = slice(start, start + CHUNK_POINTS)
        P = graded.form_products([t[:, part] for t in tables[:-1]], 0, top, scratch)
        for form, out in zip(forms, outs, strict=True):
            form.into(out[:, part], P, tables[-1][:, part])
    return outs


@dataclass(frozen=True, eq=False)
class _GroupedCoefficients:
    """The coefficients of p polynomials of degree n as matrices, one for each group of degrees k of the last variable.

    Attributes
    ----------
    degree
        n.
    groups
        The groups of degrees k, each a slice of 0 … n.
    matrices
        For each group of size g the coefficients (g · p, products) of the products of the other variables.

    """

    degree: int
    groups: list[slice]
    matrices: list[FloatArray]

    @classmethod
    def of(cls, tensors: FloatArray) -> Self:
        """Return the matrices of p tensors (p, n+1, …, n+1)."""
        dimension, degree = tensors.ndim - 1, tensors.shape[-1] - 1
        leading = graded.exponents(dimension - 1, degree)
        width = DEGREES_TOGETHER if dimension > 2 else degree + 1
        groups = [slice(k, min(k + width, degree + 1)) for k in range(0, degree + 1, width)]
        A = np.moveaxis(tensors, -1, 0)[(..., *leading.T)]  # (n+1, p, products)
        counts = [graded.count(dimension - 1, degree - group.start) for group in groups]
        matrices = [A[group, :, :count].reshape(-1, count) for group, count in zip(groups, counts, strict=True)]
        return cls(degree, groups, matrices)

    def into(self, out: FloatArray, P: FloatArray, last: FloatArray) -> None:
        """Write the values into `out` (p, N).

        `P` (≥ products, N) are the products of the other variables, `last` (≥ n+1, N) the functions of the last one.
        """
        sums = np.empty((self.degree + 1, *out.shape))
        for group, a in zip(self.groups, self.matrices, strict=True):
            np.matmul(a, P[: a.shape[1]], out=sums[group].reshape(len(a), -1))
        np.einsum("kpn,kn->pn", sums, last[: self.degree + 1], out=out)
