"""Every degree to 12 of the same 3L rows: numpy, scikit-learn and LAPACK against ipfit.

The others get what helps them: the points are normalised, numpy's matrix is filled once for all degrees, and LAPACK
factors it once, in place, with the right-hand side as its last column and without Q.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import LinAlgWarning, lapack, solve_triangular

import ipcore
from contest import clouds
from contest.clouds import Cloud
from contest.fitting import FEW, TOP, closeness, fitted
from contest.process import Asked, alone
from contest.rounds import Scores, how_many, interleaved, seconds_of
from contest.target import Target, at_least
from contest.trial import Contender, Trial
from evidence.table import table
from ipcore.constraints.family import RowParameters
from ipcore.constraints.three_layer import ThreeLayer
from ipcore.polynomial import graded, univariate
from sets import FloatArray

COUNT = 30_000
LAYER = 0.05  # c, ipfit's default
RIDGE = 1e-8  # κ: small enough not to show, and Ridge still solves by Cholesky factors
LSTSQ, SKLEARN, LAPACK = (
    "numpy lstsq, every degree",
    "scikit-learn Ridge, every degree",
    f"LAPACK QR, degree {TOP} alone",
)
AUTO, AUTO_BARE = "ipfit auto", "ipfit auto, zero set not measured"
FASTER = {LSTSQ: 40.0, LAPACK: 5.0}


@dataclass(frozen=True, eq=False)
class Rows:
    """The 3L rows of a cloud: positions (rows, 3) in its frame, and b (rows,)."""

    positions: FloatArray
    b: FloatArray
    frame: ipcore.Frame

    @classmethod
    def of(cls, cloud: Cloud) -> "Rows":
        """Lay three layers along the normals."""
        frame = ipcore.Frame.of(cloud.points)
        rows = ThreeLayer().rows(frame.to_local(cloud.points), cloud.normals, RowParameters(LAYER, 0.0))
        return cls(np.concatenate([group.positions for group in rows.groups]), rows.b(1), frame)

    def columns(self) -> FloatArray:
        """Return all monomials of degree ≤ TOP at the positions, (rows, m), column by column."""
        tables = [univariate.table(univariate.Basis.MONOMIAL, np.ascontiguousarray(x), TOP) for x in self.positions.T]
        return graded.products(tables, graded.exponents(3, TOP)).T

    def polynomial(self, a: FloatArray) -> ipcore.ImplicitPolynomial:
        """Return the polynomial with these coefficients, in graded order."""
        box = self.frame.to_raw(np.stack([self.positions.min(axis=0), self.positions.max(axis=0)]))
        return ipcore.ImplicitPolynomial(TOP, a, self.frame, box)


def lstsq(cloud: Cloud) -> ipcore.ImplicitPolynomial:
    """Solve anew at every degree, by numpy."""
    rows = Rows.of(cloud)
    M = rows.columns()
    for degree in range(1, TOP + 1):
        solution = np.linalg.lstsq(M[:, : graded.count(3, degree)], rows.b, rcond=None)
    return rows.polynomial(np.asarray(solution[0], dtype=float))


def sklearn_ridge(cloud: Cloud) -> ipcore.ImplicitPolynomial:
    """Make features and solve at every degree, by scikit-learn."""
    from sklearn.linear_model import Ridge  # noqa: PLC0415 - only this contender's process is to load it
    from sklearn.preprocessing import PolynomialFeatures  # noqa: PLC0415 - as above

    rows = Rows.of(cloud)
    warnings.simplefilter("ignore", LinAlgWarning)  # it solves ill-conditioned systems, and says so every time
    for degree in range(1, TOP + 1):
        features = PolynomialFeatures(degree)
        model = Ridge(alpha=RIDGE, fit_intercept=False).fit(features.fit_transform(rows.positions), rows.b)
    a = np.zeros(graded.count(3, TOP))
    a[graded.column(features.powers_.astype(np.intp))] = model.coef_
    return rows.polynomial(a)


def lapack_qr(cloud: Cloud) -> ipcore.ImplicitPolynomial:
    """Factor [M b] once and solve, by LAPACK."""
    rows = Rows.of(cloud)
    M = rows.columns()
    both = np.empty((len(M), M.shape[1] + 1), order="F")
    both[:, :-1], both[:, -1] = M, rows.b
    del M
    work = int(lapack.dgeqrf_lwork(*both.shape)[0])
    R = lapack.dgeqrf(both, lwork=work, overwrite_a=True)[0][: both.shape[1]]
    return rows.polynomial(solve_triangular(R[:-1, :-1], R[:-1, -1]))


def ipfit(factor: str, cloud: Cloud, **more: Any) -> ipcore.ImplicitPolynomial:  # noqa: ANN401 - as in `fitted`
    """Fit by one of ipfit's ways."""
    return fitted(cloud, factor, **more).polynomial


WAYS: dict[str, Callable[[Cloud], ipcore.ImplicitPolynomial]] = {
    LSTSQ: lstsq,
    SKLEARN: sklearn_ridge,
    LAPACK: lapack_qr,
    "ipfit block": partial(ipfit, "block"),
    "ipfit tsqr": partial(ipfit, "tsqr"),
    "ipfit moments": partial(ipfit, "moments"),
    AUTO: partial(ipfit, "auto"),
    AUTO_BARE: partial(ipfit, "auto", measure_zero_set=False),
}


def contender(way: str) -> Contender:
    """Return a way as what a process runs."""

    def ready(folder: Path) -> Trial:
        cloud, work = Cloud.load(folder, "cloud"), WAYS[way]
        few = cloud.first(FEW)
        return Trial(lambda: work(few), lambda: work(cloud), lambda found: closeness(found, cloud))

    return ready


CONTENDERS = {way: contender(way) for way in WAYS}


def contest(folder: Path, seconds: float) -> Scores:
    """Let all take turns on the same points."""
    Cloud.of(clouds.named(clouds.names()[0], COUNT)).save(folder, "cloud")
    return interleaved(list(WAYS), lambda way: alone(Asked("degrees", way, folder)), seconds)


def targets(scores: Scores) -> list[Target]:
    """Return how much faster auto is, against what was asked for."""
    auto, bare = (seconds_of(scores, way) for way in (AUTO, AUTO_BARE))
    lines = []
    for other, asked in FASTER.items():
        taken = seconds_of(scores, other)
        note = f" ({taken / bare:.1f} when the zero set is not measured)" if isfinite(bare) else ""
        lines.append(at_least(f"times faster than {other}", taken / auto, asked, note=note))
    return lines


def shown(scores: Scores) -> str:
    """Return the table and what it is of."""
    name, best = clouds.names()[0], seconds_of(scores, AUTO)
    lines = []
    for way, one in scores.items():
        if one.failed:
            lines.append([way, one.failed, *[""] * 6])
            continue
        found = one.found
        cells = [f"{one.seconds:.3f}", f"{one.seconds / best:.1f}", f"{one.cpu:.3f}", f"{one.first:.2f}"]
        lines.append([way, *cells, f"{one.above:.0f}", f"{found['d_dist']:.6f}", f"{found['d_smooth']:.5f}"])
    heads = ["way", "s", "÷ auto", "CPU s", "first, s", "peak MB", "D_dist", "D_smooth"]
    return f"{COUNT:,} points of {name} at most. {how_many(scores)}.\n\n{table(heads, lines)}"
