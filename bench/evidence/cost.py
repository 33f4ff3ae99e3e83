"""The cost of incremental solves beside that of repeated ones. Only the solves are timed, not the making of M."""

from collections.abc import Callable, Iterable
from itertools import pairwise
from statistics import median
from time import perf_counter

import numpy as np
from scipy.linalg import lstsq

from evidence.table import table
from ipcore.linear.qr.block_gram_schmidt import BlockGramSchmidt
from ipcore.linear.qr.factorisation import Factorisation, Policy
from ipcore.linear.qr.gram_schmidt import GramSchmidt
from ipcore.polynomial import graded
from ipcore.polynomial.frame import Frame
from ipcore.polynomial.univariate import Basis
from ipcore.polynomial.univariate import table as powers
from sets import FloatArray, PointSet, load

CASES = (("nucleus", 12), ("mp7_heart", 12), ("bunny_npm", 8), ("spot", 10))
REPEATS = 3
C = 0.05


class System:
    """The 3L system M a = b of a set up to a degree, in monomials of the frame, with all columns in memory."""

    def __init__(self, given: PointSet, degree: int) -> None:
        """Fill M (rows, m) and b."""
        if given.normals is None:
            raise ValueError(f"{given.name} has no normals")
        x, offset, d = Frame.of(given.points).to_local(given.points), C * given.normals, given.dimension
        layers = np.concatenate([x, x + offset, x - offset])
        tables = [powers(Basis.MONOMIAL, np.ascontiguousarray(row), degree) for row in layers.T]
        self.M: FloatArray = np.asfortranarray(graded.products(tables, graded.exponents(d, degree)).T)
        self.b = np.repeat([0.0, C, -C], len(x))
        self.forms = [0, *(graded.count(d, n) for n in range(degree + 1))]

    def at_every_column(self) -> None:
        """Solve from scratch for α = 1, 2, …, by LAPACK's QR with pivoting."""
        for alpha in range(1, self.M.shape[1] + 1):
            lstsq(self.M[:, :alpha], self.b, lapack_driver="gelsy", check_finite=False)

    def at_every_degree(self) -> None:
        """Solve from scratch for every complete degree."""
        for end in self.forms[1:]:
            lstsq(self.M[:, :end], self.b, lapack_driver="gelsy", check_finite=False)

    def by_columns(self) -> None:
        """Raise α by eq. (5), and solve R a = b̃ for each."""
        self._raise(GramSchmidt(self.b, Policy(0.0)), range(self.M.shape[1] + 1))

    def by_forms(self) -> None:
        """Raise the degree by block Gram–Schmidt done twice, and solve R a = b̃ for each."""
        self._raise(BlockGramSchmidt(self.b, Policy(0.0)), self.forms)

    def _raise(self, factor: Factorisation, ends: Iterable[int]) -> None:
        for start, end in pairwise(ends):
            factor.append(self.M[:, start:end])
            factor.solve()


def seconds(run: Callable[[], None]) -> float:
    """Return the median time of some runs."""
    taken = []
    for _ in range(REPEATS):
        started = perf_counter()
        run()
        taken.append(perf_counter() - started)
    return median(taken)


def rows() -> str:
    """Return a table of the four methods, with the time of each and its ratio to the last one."""
    heads = [
        "set",
        "rows × columns",
        "anew at every column",
        "anew at every degree",
        "column-wise, eq. (5)",
        "form-wise, twice",
    ]
    lines = []
    for name, degree in CASES:
        system = System(load(name).sample(2000), degree)
        methods = (system.at_every_column, system.at_every_degree, system.by_columns, system.by_forms)
        taken = [seconds(method) for method in methods]
        cells = [f"{1e3 * t:.1f} ms ({t / taken[-1]:.1f} ×)" for t in taken[:-1]] + [f"{1e3 * taken[-1]:.1f} ms"]
        lines.append([f"{name}, degree {degree}", f"{system.M.shape[0]} × {system.M.shape[1]}", *cells])
    return table(heads, lines)
