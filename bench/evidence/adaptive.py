"""Fig. 4: the adaptive fit over shapes of differing complexity."""

from matplotlib.figure import Figure

import ipcore
from evidence.plot import new, outline, surface
from evidence.shapes import everything, fitted
from evidence.table import table
from sets import PointSet

PER_ROW = 6


class Adaptive:
    """The fit of every set, by the paper's rule and by complete degrees."""

    def __init__(self) -> None:
        """Fit all sets."""
        self.fits: list[tuple[PointSet, ipcore.FitResult]] = [(given, fitted(given)) for given in everything()]

    def rows(self) -> str:
        """Return a table of the fits: degree, closeness at the data, and stray parts away from the data."""
        heads = ["set", "points", "degree", "coefficients", "stop", "D_dist", "D_smooth", "stray", "pieces", "bounded"]
        return table(heads, [self._row(*pair) for pair in self.fits])

    def figure(self) -> Figure:
        """Return the figure of all fits; parts of a zero set that lie away from the points are red."""
        height = -(-len(self.fits) // PER_ROW)
        picture, axes = new(height, PER_ROW, 2.0)
        for axis in axes[len(self.fits) :]:
            axis.set_axis_off()
        for axis, (given, fit) in zip(axes, self.fits, strict=False):
            (outline if given.dimension == 2 else surface)(axis, given, fit.polynomial)
            axis.set_title(f"{given.name}: {fit.degree}" + ("" if met(fit) else " (cap)"))
        return picture

    @staticmethod
    def _row(given: PointSet, fit: ipcore.FitResult) -> list[str]:
        found = fit.diagnostics
        return [
            given.name,
            str(len(given.points)),
            str(fit.degree),
            str(len(fit.polynomial.coefficients)),
            str(fit.stop_reason),
            f"{found.d_dist:.4f}",
            f"{found.d_smooth:.3f}",
            "" if found.stray is None else f"{found.stray:.2f}",
            str(found.components),
            "yes" if found.bounded else "no",
        ]


def met(fit: ipcore.FitResult) -> bool:
    """Return whether the stopping rule ended the search."""
    return fit.stop_reason is ipcore.StopReason.CRITERION_MET
