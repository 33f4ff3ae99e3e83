"""Evaluate f = Σ a_ijk X_i(x) Y_j(y) Z_k(z) by matrix products, never term by term."""

from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from ipcore._typing import ExtendedArray, FloatArray
from ipcore.polynomial import graded

Array = TypeVar("Array", FloatArray, ExtendedArray)

TOGETHER = 2  # degrees of the last of three variables in one matrix product: with more, more of its factor is zeros
CHUNK = 4096  # points at once: the products and sums of a degree-12 surface with its gradient take 5 MB


def to_tensor(coefficients: Array, dimension: int, degree: int) -> Array:
    """Spread coefficients in graded order (…, m) over a tensor (…, n+1, …, n+1), zero beyond total degree n."""
    tensor = np.zeros((*coefficients.shape[:-1], *(degree + 1,) * dimension), dtype=coefficients.dtype)
    tensor[(..., *graded.exponents(dimension, degree).T)] = coefficients
    return tensor


def from_tensor(tensor: Array, dimension: int, degree: int) -> Array:
    """Gather a tensor's coefficients in graded order: the inverse of `to_tensor`."""
    return tensor[(..., *graded.exponents(dimension, degree).T)]


def along_axes(tensor: Array, matrices: list[Array]) -> Array:
    """Multiply each axis of a tensor by its matrix: out_abc = Σ_ijk A_ai B_bj C_ck tensor_ijk.

    With the matrices (N_axis, n+1) of univariate values at grid lines this evaluates on the grid, in O(n · N^d).
    """
    for matrix in matrices:  # the contracted axis goes last, so after d steps the axes stand in order again
        rest = tensor.shape[1:]
        tensor = (tensor.reshape(len(tensor), -1).T @ matrix.T).reshape(*rest, len(matrix))  # np.tensordot, without
    return tensor


def scattered(tensors: FloatArray, tables: list[FloatArray]) -> FloatArray:
    """Evaluate p polynomials of one degree at the same N points.

    Parameters
    ----------
    tensors
        (p, n+1, …, n+1), coefficients, zero beyond total degree n.
    tables
        One (≥ n+1, N) per variable.

    Returns
    -------
        (p, N)

    """
    return scattered_stacks([tensors], tables)[0]


def scattered_stacks(stacks: list[FloatArray], tables: list[FloatArray]) -> list[FloatArray]:
    """Evaluate stacks of polynomials, each of a degree of its own, at the same N points; as `scattered` each.

    The products of the first d − 1 variables are formed once; matrix products with the coefficients, then one weighted
    sum over the last variable's functions, do the rest. With the last one's degree k goes a prefix of the products, of
    degree ≤ n − k. In 3D, with a few k at once to leave out most of the zeros, that takes about p n³/4 multiplications
    per point in BLAS-3.
    """
    top, N = max(len(stack[0]) for stack in stacks) - 1, tables[0].shape[1]
    forms = [_Form.of(stack) for stack in stacks]
    outs = [np.empty((len(stack), N)) for stack in stacks]
    scratch = np.empty((graded.count(len(tables) - 1, top), min(CHUNK, N)))
    for start in range(0, N, CHUNK):
        part = slice(start, start + CHUNK)
        P = graded.form_products([t[:, part] for t in tables[:-1]], 0, top, scratch)
        for form, out in zip(forms, outs, strict=True):
            form.into(out[:, part], P, tables[-1][:, part])
    return outs


@dataclass(frozen=True, eq=False)
class _Form:
    """The coefficients of p polynomials of degree n as matrices (k · p, products), for some degrees k each."""

    degree: int
    groups: list[slice]
    matrices: list[FloatArray]

    @classmethod
    def of(cls, tensors: FloatArray) -> Self:
        dimension, degree = tensors.ndim - 1, tensors.shape[-1] - 1
        leading = graded.exponents(dimension - 1, degree)
        width = TOGETHER if dimension > 2 else degree + 1
        groups = [slice(k, min(k + width, degree + 1)) for k in range(0, degree + 1, width)]
        A = np.moveaxis(tensors, -1, 0)[(..., *leading.T)]  # (n+1, p, products)
        counts = [graded.count(dimension - 1, degree - group.start) for group in groups]
        matrices = [A[group, :, :count].reshape(-1, count) for group, count in zip(groups, counts, strict=True)]
        return cls(degree, groups, matrices)

    def into(self, out: FloatArray, P: FloatArray, last: FloatArray) -> None:
        """Write the values (p, N), given the products of the other variables and the functions of the last."""
        sums = np.empty((self.degree + 1, *out.shape))
        for group, a in zip(self.groups, self.matrices, strict=True):
            np.matmul(a, P[: a.shape[1]], out=sums[group].reshape(len(a), -1))
        np.einsum("kpn,kn->pn", sums, last[: self.degree + 1], out=out)
