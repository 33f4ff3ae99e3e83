"""The result of a fit: the polynomial, the trace of the search, and what was measured of the answer."""

from dataclasses import asdict, dataclass
from typing import Any

from ipcore.options.fit_options import FitOptions
from ipcore.points.normals import NormalSource
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.proof.prover import Proof
from ipcore.search.fit_warning import FitWarning
from ipcore.search.stop_reason import StopReason


@dataclass(frozen=True)
class Step:
    """One fit of the search: with all columns of a degree, or with the first α = columns + dropped columns.

    Attributes
    ----------
    degree
        The total degree n of the last column.
    columns
        How many coefficients are in use.
    dropped
        How many coefficients are left out, because their columns are collinear with earlier ones.
    d_dist, d_smooth
        Closeness in mean radii and smoothness (the paper's eq. 6) at the data.
    rss
        Residual sum of squares ‖M a − b‖², in squared mean radii.
    gcv
        Generalised cross-validation, rows · rss / (rows − k)², k the degrees of freedom: columns, or less if ridged.
    condition
        Estimated 1-norm condition of R with columns scaled to length 1, in the basis that the fit is computed in.
    seconds
        Wall-clock time of this step.
    ridged
        How many coefficients are damped by ridge regression.
    bic
        Schwarz' criterion; None unless it is the criterion of the search.
    loo
        Mean squared error of the rows of points left out one by one, in squared mean radii; None unless it is the
        criterion of the search.
    diagonal_ratio
        max |r_ii| / min |r_ii|, the paper's measure of the condition (section 5.1): only a lower bound of it.
    iterations
        Iterations of the geometric fit or of that under sign constraints; 0 if the fit is linear. If it is not, `rss`
        is the sum of squared first-order distances, and `condition` and `diagonal_ratio` are those of the Jacobian.
    quiet
        Whether the zero set was found near the data only, and whole, on a fine grid; None if that was not checked,
        because the fit is linear or still far from the criterion.
    coverage
        Share of the data that have a zero of f within 3 t1; None if that was not checked, because D_dist is not below
        t1.

    """

    degree: int
    columns: int
    dropped: int
    d_dist: float
    d_smooth: float
    rss: float
    gcv: float
    condition: float
    seconds: float
    ridged: int = 0
    bic: float | None = None
    loo: float | None = None
    diagonal_ratio: float | None = None
    iterations: int = 0
    quiet: bool | None = None
    coverage: float | None = None

    @property
    def alpha(self) -> int:
        """Return α, the number of columns of Table 1 that were tried."""
        return self.columns + self.dropped


@dataclass(frozen=True)
class Diagnostics:
    """What is known of the returned polynomial. Distances are in mean radii.

    D_dist, D_smooth and the maximum are over all points. For the other figures, 50,000 points at most are taken.

    Attributes
    ----------
    d_dist, d_smooth
        Closeness and smoothness of the returned coefficients, so with the rounding of a conversion to their basis.
    distance_p95, distance_max
        95th percentile and maximum of the distance |f|/‖∇f‖ over the data.
    stray
        Share of the zero set's length or area, within the bounds, that lies away from all data; None if there is no
        zero set, or it was not measured.
    components
        Connected components of the zero set within the bounds; None if not measured, or too small for the finest grid.
    normal_source
        Where the normals came from: the caller, the order of the outline, or estimation.
    normal_self_check
        Share of the points whose normal points from inside to outside, by the winding number of all points and normals.
        It is near 0 for inward normals, and lower for open surfaces and where some normals point the wrong way.
    bounded
        Whether the leading form is definite: then the degree is even and no part of the zero set extends to infinity.
    orthogonality_loss
        ‖QᵀQ − I‖₂ of the paper's eq. (5), which loses orthogonality; None for factorisations that keep it.
    quiet
        Whether the zero set is proved to lie near the data only, and was found whole on a fine grid; None without
        sign constraints, or if the zero set was not to be measured. Where neighbouring points are farther apart than
        the support radius, a zero set that crosses the gap is quiet.
    unsure
        Share of the box, without what is near the data, where the data do not tell inside from outside; None without
        sign constraints.
    outliers
        Share of the distinct points that a robust fit left out, and that no other figure counts; None if the fit is not
        robust.
    coverage
        Share of the data that have a zero of f within 3 t1, shown by a change of the sign of f.
    merged
        How many of the given points were copies of others; each place is fitted once.

    """

    d_dist: float
    d_smooth: float
    distance_p95: float
    distance_max: float
    stray: float | None
    components: int | None
    normal_source: NormalSource
    normal_self_check: float
    bounded: bool | None = None
    orthogonality_loss: float | None = None
    quiet: bool | None = None
    unsure: float | None = None
    outliers: float | None = None
    coverage: float | None = None
    merged: int = 0


@dataclass(frozen=True, eq=False)
class FitResult:
    """A fit: the polynomial, what was measured of it, and what is needed to repeat it.

    Attributes
    ----------
    polynomial
        The answer, in the caller's coordinates.
    stop_reason
        Why the search ended; `stop_reason.advice` says what to do about it.
    steps
        All fits that were made, in order.
    diagnostics
        What was measured of the answer at the data, and of its zero set.
    warnings
        What a careful user should know, each with a code and in plain words.
    options
        The options of the fit.
    version
        The version of this library.
    input_sha256
        SHA-256 of the points and normals as they were used: shape, then doubles, little-endian, in C order.
    proof
        What was proved of its zero set, in the caller's coordinates; None if nothing was tried, because the zero set
        was not to be measured or was seen to stray.

    """

    polynomial: ImplicitPolynomial
    stop_reason: StopReason
    steps: tuple[Step, ...]
    diagnostics: Diagnostics
    warnings: tuple[FitWarning, ...]
    options: FitOptions
    version: str
    input_sha256: str
    proof: Proof | None = None

    @property
    def degree(self) -> int:
        """Return the chosen degree."""
        return self.polynomial.degree

    def to_dict(self) -> dict[str, Any]:
        """Return plain values, ready for JSON."""
        return {
            "polynomial": self.polynomial.to_dict(),
            "stop_reason": str(self.stop_reason),
            "steps": [asdict(step) for step in self.steps],
            "diagnostics": asdict(self.diagnostics),
            "proof": None if self.proof is None else asdict(self.proof),
            "warnings": [warning.to_dict() for warning in self.warnings],
            "options": self.options.to_dict(),
            "engine": {"version": self.version, "input_sha256": self.input_sha256},
        }
