"""What a fit returns."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from ipcore.options.fit_options import FitOptions
from ipcore.points.normals import NormalSource
from ipcore.polynomial.implicit import ImplicitPolynomial


class StopReason(StrEnum):
    """Why no higher degree was tried."""

    CRITERION_MET = "criterion-met"
    MAX_DEGREE = "max-degree"
    TOO_FEW_POINTS = "too-few-points"
    PLANAR = "planar"
    CRITERION_MINIMUM = "criterion-minimum"
    DEGREE_REACHED = "degree-reached"
    ILL_CONDITIONED = "ill-conditioned"

    @property
    def advice(self) -> str:
        """Return what happened and what to do about it, in one sentence."""
        return _ADVICE[self]


_ADVICE = {
    StopReason.CRITERION_MET: "The fit is as close and as smooth as was asked for.",
    StopReason.MAX_DEGREE: "No degree up to max_degree met the criterion, and the best one is returned: raise "
    "max_degree, or on noisy data raise t1 to about the noise or take another criterion, gcv say.",
    StopReason.TOO_FEW_POINTS: "The next degree has more coefficients than there are points, and the best fit so far "
    "is returned: give more points, or raise t1.",
    StopReason.PLANAR: "All points lie on one plane: degree 1 represents it, and no higher degree is determined.",
    StopReason.CRITERION_MINIMUM: "The criterion has passed its minimum, and the fit at the minimum is returned.",
    StopReason.DEGREE_REACHED: "The degree that was asked for is reached.",
    StopReason.ILL_CONDITIONED: "Moments alone do not determine the next degree, and the best fit so far is returned: "
    "fit the points themselves, or raise t1.",
}


@dataclass(frozen=True)
class Step:
    """One fit of the search: at a complete degree, or at one column α = columns + dropped.

    Attributes
    ----------
    degree
        The total degree n, or that in which the column lies.
    columns
        How many coefficients the fit has.
    dropped
        How many more were left out so far, because their columns are collinear with earlier ones.
    d_dist, d_smooth
        Closeness in mean radii and smoothness (the paper's eq. 6) at the data.
    rss
        Residual sum of squares of M a = b, in squared mean radii.
    gcv
        Generalised cross-validation, rows · rss / (rows − k)², k the degrees of freedom: columns, or less if ridged.
    condition
        Estimated 1-norm condition of R with columns scaled to length 1, in the basis the fit works in.
    seconds
        Wall-clock time that this step took.
    ridged
        How many of the columns are damped by ridge regression.
    bic
        Schwarz' criterion; None unless it was asked for.
    loo
        Mean squared error of the rows of points left out one by one, in squared mean radii; None unless asked for.
    diagonal_ratio
        max |r_ii| / min |r_ii|, by which the paper judges the condition (section 5.1): only a lower bound of it.
    iterations
        Steps of the geometric fit or of that under sign constraints; 0 if it is linear. `rss` is then the sum of
        squared first-order distances, and `condition` and `diagonal_ratio` are those of the Jacobian.
    quiet
        Whether the zero set was found near the data only, and whole, on two fine grids; None if that was not looked
        at, because the fit is linear or still far from the criterion.

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

    @property
    def alpha(self) -> int:
        """Return α, how many columns of Table 1 were tried so far."""
        return self.columns + self.dropped


@dataclass(frozen=True)
class Diagnostics:
    """What is known of the returned polynomial. Distances are in mean radii.

    D_dist, D_smooth and the maximum are over all points; of more than 50,000, a sample of so many stands for the rest.

    Attributes
    ----------
    d_dist, d_smooth
        As delivered, so including what the answer's basis costs.
    distance_p95, distance_max
        95th percentile and maximum of |f|/‖∇f‖ over the data.
    stray
        Share of the zero set's length or area, within the bounds, that lies away from all data; None if not measured.
    components
        Connected components of the zero set within the bounds; None if not measured.
    normal_source
        Where the normals came from: the caller, the order of the outline, or estimation.
    normal_self_check
        Share of points whose normal has the inside behind it and the outside before it, by the winding number of all.
        It tells outward from inward, and falls for open surfaces and for wrongly oriented normals.
    bounded
        Whether the leading form is definite: then the degree is even and no part of the zero set runs to infinity.
    orthogonality_loss
        ‖QᵀQ − I‖₂ of the paper's eq. (5), which loses orthogonality; None where another factorisation keeps it.
    quiet
        Whether, with signs constrained, the zero set kept to the data and was whole on two fine grids; None if that was
        not asked for. Where points are farther apart than what counts as stray, it crosses the gap and is quiet still.
    unsure
        Share of the box, without what is near the data, where the data do not tell inside from outside.
    outliers
        Share of the points that a robust fit left out, and that no other figure counts; None without it.

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


@dataclass(frozen=True, eq=False)
class FitResult:
    """A fit, the evidence for it, and what makes it repeatable.

    Attributes
    ----------
    polynomial
        The answer, in the caller's coordinates.
    stop_reason
        Why the search ended; `stop_reason.advice` says what to do about it.
    steps
        Every degree or column that was tried, in order.
    diagnostics
        The answer seen from the data, and its zero set.
    warnings
        What a careful user should know, in plain words.
    options
        As asked for.
    version
        Of this library.
    input_sha256
        SHA-256 of the points and normals as they were used: shape, then doubles, little-endian, in C order.

    """

    polynomial: ImplicitPolynomial
    stop_reason: StopReason
    steps: tuple[Step, ...]
    diagnostics: Diagnostics
    warnings: tuple[str, ...]
    options: FitOptions
    version: str
    input_sha256: str

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
            "warnings": list(self.warnings),
            "options": self.options.to_dict(),
            "engine": {"version": self.version, "input_sha256": self.input_sha256},
        }
