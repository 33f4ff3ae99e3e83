"""Points and curves in the plane of a picture: where they lie in px, and how a fit in 2D is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.spatial import cKDTree

import ipcore

WIDTH, HEIGHT = 470.0, 396.0  # px, of the space for a shape
BLUE, WARNING, INK, INSIDE, RIM = "#2463a6", "#e8590c", "#1f2933", "#e3eef9", "#c3ccd5"
MOST_DOTS = 1500
LEAST_SHARE = 0.01  # of the data, that a piece of the zero set must hold to be what they describe

LegendEntries = Sequence[tuple[str, str]]  # symbol, drawn about the origin, and label


@dataclass(frozen=True, eq=False)
class Placing:
    """The map of a plane, y up, into a picture, y down: px = middle + scale · (x − centre), y mirrored.

    Attributes
    ----------
    centre
        (2,), of what is placed, in its own unit.
    scale
        px per unit, the same along both axes.
    middle
        (2,), px, where the centre goes.

    """

    centre: ipcore.FloatArray
    scale: float
    middle: ipcore.FloatArray

    @classmethod
    def into(cls, width: float, height: float, corners: ipcore.FloatArray) -> Self:
        """Return the map that makes the box with these corners (2, 2) as large as fits, in the middle.

        >>> Placing.into(200.0, 100.0, np.array([[0.0, 0.0], [1.0, 1.0]]))(np.array([[0.0, 0.0], [1.0, 1.0]])).tolist()
        [[50.0, 100.0], [150.0, 0.0]]
        """
        sides = np.maximum(corners[1] - corners[0], np.finfo(float).tiny)
        return cls(
            corners.mean(axis=0), float((np.array([width, height]) / sides).min()), np.array([width, height]) / 2
        )

    def __call__(self, x: ipcore.FloatArray) -> ipcore.FloatArray:
        """Return where points (N, 2) lie, (N, 2), in px."""
        return self.middle + self.scale * (x - self.centre) * [1.0, -1.0]


def curve(polynomial: ipcore.ImplicitPolynomial, points: ipcore.FloatArray) -> tuple[str, LegendEntries]:
    """Draw the whole zero set in the bounds, and what of it lies away from the data in the colour of a warning.

    Returns the drawing, from the origin to the right and down, and the entries of its legend.
    """
    lines, filled = (
        ipcore.zero_set(polynomial, data=points, restrict=False, cap=False),
        ipcore.zero_set(polynomial, restrict=False),
    )
    held = supported(lines, points)
    place = Placing.into(WIDTH, HEIGHT, polynomial.bounds)
    (left, bottom), (right, top) = place(polynomial.bounds).tolist()
    box = f"M{left:.2f} {top:.2f}H{right:.2f}V{bottom:.2f}H{left:.2f}Z"
    drawing = [
        f'<path id="inside" d="{_path(filled, place)}" fill="{INSIDE}" fill-rule="evenodd"/>',
        f'<path id="box" d="{box}" fill="none" stroke="{RIM}"/>',
        dots(place(points), 4.2, 0.5),
        '<g fill="none" stroke-width="1.8" stroke-linejoin="round" stroke-linecap="round">',
        f'<path id="curve" d="{_path(_part(lines, held), place)}" stroke="{BLUE}"/>',
        f'<path id="stray" d="{_path(_part(lines, ~held), place)}" stroke="{WARNING}"/>',
        "</g>",
    ]
    legend = [(dots(np.zeros((1, 2)), 4.2, 0.6), f"{len(points):,} points"), (_dash(BLUE), "f = 0")]
    if not held.all():
        legend.append((_dash(WARNING), f"f = 0 away from the data (stray {lines.stray:.1%})"))
    return "\n".join(drawing), legend


def supported(whole: ipcore.ZeroSet, points: ipcore.FloatArray) -> ipcore.BoolArray:
    """Return which cells (C,) of a zero set are near the data (N, d) and belong to a component that describes them.

    Other components may pass near the data, too; but few of the data have their nearest vertex on them.
    """
    near = whole.cells_near(points)
    if not near.any():
        return near
    component = replace(whole, cells=whole.cells[near]).vertex_components()
    used = np.unique(whole.cells[near])
    _, nearest = cKDTree(whole.vertices[used]).query(points)
    describes = np.bincount(component[used[nearest]], minlength=component.max() + 1) >= LEAST_SHARE * len(points)
    return near & describes[component[whole.cells[:, 0]]]


def dots(at: ipcore.FloatArray, size: float, opacity: float) -> str:
    """Return points (N, 2), px, as dots, evenly thinned to MOST_DOTS: strokes of no length with round ends."""
    chosen = np.unique(np.linspace(0, len(at) - 1, min(len(at), MOST_DOTS)).round().astype(int))
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in at[chosen].tolist())
    return (
        f'<path class="dots" d="{path}" fill="none" stroke="{INK}" stroke-width="{size:g}" stroke-linecap="round" '
        f'stroke-opacity="{opacity:g}"/>'
    )


def _dash(colour: str) -> str:
    return f'<path d="M-8 0H8" stroke="{colour}" stroke-width="2.4"/>'


def _part(lines: ipcore.ZeroSet, cells: ipcore.BoolArray) -> ipcore.ZeroSet:
    return replace(lines, cells=lines.cells[cells])


def _path(lines: ipcore.ZeroSet, place: Placing) -> str:
    """Return path data; hundredths of a px, or the rounding would show as a tremor."""
    return "".join(
        "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in place(line).tolist()) + "Z" * bool((line[0] == line[-1]).all())
        for line in lines.polylines()
    )
