"""Fig. 3e: how D_dist and D_smooth grow with α, column by column, with eq. (5) and with the stable factorisation."""

from matplotlib.figure import Figure

import ipcore
from evidence.plot import new, outline
from evidence.shapes import fitted
from evidence.table import table
from sets import load

NAMES = ("cell", "nucleus", "mp7_heart", "mp7_bone", "mp7_bird")
SHOWN = "mp7_bone"
SNAPSHOTS = (4, 6, 8)


def rows() -> str:
    """Return a table: where the search by columns stopped, and the loss of orthogonality of eq. (5) there."""
    lines = []
    for name in NAMES:
        given = load(name)
        paper = fitted(given, preset="paper")
        stable = fitted(given, preset="paper", factor="block")
        lines.append([name, *stop(paper), f"{paper.diagnostics.orthogonality_loss or 0.0:.0e}", *stop(stable)])
    heads = ["outline", "eq. (5): α", "degree", "stop", "‖QᵀQ − I‖", "block: α", "degree", "stop"]
    return table(heads, lines)


def stop(fit: ipcore.FitResult) -> list[str]:
    """Return the number of columns tried, the degree and the reason of a fit."""
    best = min(fit.steps, key=lambda step: (step.degree != fit.degree, step.d_dist))
    return [str(best.alpha), str(fit.degree), str(fit.stop_reason)]


def figure() -> Figure:
    """Return the figure of D_dist and D_smooth over α, and of the fit at three degrees."""
    given = load(SHOWN)
    paper = fitted(given, preset="paper", criterion="none", max_degree=14)
    stable = fitted(given, preset="paper", criterion="none", max_degree=14, factor="block")
    picture, axes = new(1, 2 + len(SNAPSHOTS), 2.6)
    for fit, label in ((stable, "Gram–Schmidt twice"), (paper, "eq. (5)")):
        alphas = [step.alpha for step in fit.steps]
        axes[0].semilogy(alphas, [step.d_dist for step in fit.steps], lw=1, label=label)
        axes[1].plot(alphas, [step.d_smooth for step in fit.steps], lw=1, label=label)
    for axis, threshold, title in ((axes[0], 0.01, "D_dist"), (axes[1], 0.95, "D_smooth")):
        axis.axhline(threshold, color="0.6", lw=0.8, ls="--")
        axis.set_title(f"{title} against α")
    axes[0].legend(fontsize=6, frameon=False)
    for axis, degree in zip(axes[2:], SNAPSHOTS, strict=True):
        fit = fitted(given, criterion="none", max_degree=degree)
        outline(axis, given, fit.polynomial)
        axis.set_title(f"degree {degree}, D_dist {fit.diagnostics.d_dist:.3f}")
    return picture
