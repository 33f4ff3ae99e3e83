"""Which criterion to use when: fits of points with noise, measured at the points without noise."""

from collections.abc import Iterator
from statistics import mean
from typing import Any

from matplotlib.figure import Figure

import ipcore
from evidence.adaptive import met
from evidence.plot import new
from evidence.shapes import CAP, closeness, everything, fitted
from evidence.table import table
from sets import PointSet

SIGMAS = (0.0, 0.01, 0.02, 0.04)
RAISED, QUIET = "distance, t1 = σ", "geometric, t1 = σ"
CRITERIA = ("distance", RAISED, "gcv", "bic", "loo", "none", QUIET)
COLOURS = dict(
    zip(
        (*CRITERIA, "best"), ("#1f5fa8", "#7fb2e5", "#e4572e", "#3a9d5d", "#8e5ea2", "0.6", "#d4a017", "k"), strict=True
    )
)


def options(criterion: str, sigma: float) -> dict[str, Any]:
    """Return the fit options of a criterion (a name in `CRITERIA`) at a noise level."""
    if criterion in {RAISED, QUIET}:
        return {"t1": max(sigma, 0.01), "geometric": criterion == QUIET}
    return {"criterion": criterion}


class Noise:
    """The fits of every set at every noise level, by every criterion."""

    def __init__(self, points: int = 1500) -> None:
        """Make all fits. The normals are those without noise."""
        self._sets = [given.sample(points) for given in everything()]
        self.fits = {
            (sigma, criterion): [fitted(given.noisy(sigma), **options(criterion, sigma)) for given in self._sets]
            for sigma in SIGMAS
            for criterion in CRITERIA
        }
        self.best = {sigma: [self._best(given, sigma) for given in self._sets] for sigma in SIGMAS}

    def errors(self, sigma: float, criterion: str) -> list[float]:
        """Return, for each set, the mean distance of its points without noise from the fit, in mean radii."""
        if criterion == "best":
            return self.best[sigma]
        pairs = zip(self._sets, self.fits[sigma, criterion], strict=True)
        return [closeness(fit.polynomial, given)[0] for given, fit in pairs]

    def rows(self) -> str:
        """Return a table by noise and criterion: true error, degrees, and how many searches reached the last degree."""
        heads = ["σ", "criterion", "true error 2D", "3D", "worst", "D_smooth", "degree 2D", "3D", "stray", "at the cap"]
        lines = [list(self._row(sigma, criterion)) for sigma in SIGMAS for criterion in (*CRITERIA, "best")]
        return table(heads, lines)

    def figure(self) -> Figure:
        """Return the figure of the true error over the noise, in 2D and in 3D."""
        picture, axes = new(1, 2, 3.2)
        for axis, d in zip(axes, (2, 3), strict=True):
            for criterion in (*CRITERIA, "best"):
                error = [mean(self._of(d, self.errors(sigma, criterion))) for sigma in SIGMAS]
                axis.plot(SIGMAS, error, "o-", ms=3, lw=1, color=COLOURS[criterion], label=criterion)
            axis.set_title(f"mean true error in {d}D, mean radii")
            axis.set_xlabel("σ, mean radii", fontsize=7)
        axes[0].legend(fontsize=6, frameon=False)
        return picture

    def _row(self, sigma: float, criterion: str) -> Iterator[str]:
        errors = self.errors(sigma, criterion)
        yield f"{sigma:g}"
        yield "the best degree" if criterion == "best" else f"`{criterion}`"
        yield from (f"{mean(self._of(d, errors)):.4f}" for d in (2, 3))
        yield f"{max(errors):.4f}"
        if criterion == "best":
            yield from ["", "", "", "", ""]
            return
        fits = self.fits[sigma, criterion]
        pairs = zip(self._sets, fits, strict=True)
        yield f"{mean(closeness(fit.polynomial, given)[1] for given, fit in pairs):.3f}"
        yield from (f"{mean(self._of(d, [float(fit.degree) for fit in fits])):.1f}" for d in (2, 3))
        yield f"{mean(fit.diagnostics.stray or 0.0 for fit in fits):.2f}"
        ended = [fit for fit in fits if met(fit) or fit.stop_reason is ipcore.StopReason.CRITERION_MINIMUM]
        yield f"{len(fits) - len(ended)} of {len(fits)}"

    def _of(self, d: int, values: list[float]) -> list[float]:
        return [value for given, value in zip(self._sets, values, strict=True) if given.dimension == d]

    @staticmethod
    def _best(given: PointSet, sigma: float) -> float:
        """Return the least true error of any degree, which no criterion can improve on."""
        noisy = given.noisy(sigma)
        plain = {"measure_zero_set": False, "criterion": "none"}
        degrees = range(1, CAP[given.dimension] + 1)
        return min(closeness(fitted(noisy, max_degree=n, **plain).polynomial, given)[0] for n in degrees)
