"""The right half of a picture: charts of D_dist and D_smooth at every degree, with the thresholds of eq. (7)."""

from dataclasses import dataclass
from html import escape
from math import ceil, floor

import numpy as np

import ipcore
from service.formats.picture.plane import BLUE, LegendEntries

LEFT, CHART_WIDTH = 46.0, 352.0  # px, the left and the right side of the charts; the labels stand outside
TOPS, CHART_HEIGHT = (24.0, 228.0), 150.0  # px, of the two charts, one above the other
GREEN, GRID, QUIET = "#2b8a3e", "#e4e8ec", "#52606d"

# The decades that a logarithmic axis shows: below them is rounding, and above them all fits are useless alike.
DECADES = (-17.0, 2.0)
PLAIN = (-3, 2)  # decades whose labels are written as decimals, 0.001 … 100
MOST_DECADES, MOST_COSINES, MOST_DEGREES = 5, 6, 12  # the most ticks, and labels of degrees
COSINE_STEPS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

DASHED = f'stroke="{GREEN}" stroke-width="1.3" stroke-dasharray="4 3"'
TRIED = f'<circle r="3" fill="{BLUE}"/>'
CHOSEN = f'<circle r="7" fill="none" stroke="{BLUE}" stroke-width="1.6"/>'
ENOUGH = f'<rect x="-8" y="-5" width="16" height="10" fill="{GREEN}" fill-opacity="0.09"/><path d="M-8 -5H8" {DASHED}/>'


@dataclass(frozen=True, eq=False)
class Chart:
    """The chart of one measure by degree.

    Attributes
    ----------
    name, heading
        The id of the SVG group, and the title.
    values
        (k,), one for each step, in the unit of the axis; some may not be finite.
    threshold, label
        The value from which on the measure is good enough, and its label.
    worst, best
        The lower and the upper end of the chart, in the unit of the axis.
    ticks
        The values at which lines are drawn across the chart, and their labels.

    """

    name: str
    heading: str
    values: ipcore.FloatArray
    threshold: float
    label: str
    worst: float
    best: float
    ticks: list[tuple[float, str]]

    def height(self, values: ipcore.FloatArray) -> ipcore.FloatArray:
        """Return the distance of values from the top, px: those off the axis are put at its end, NaN at the worst."""
        low, high = sorted((self.worst, self.best))
        inside = np.clip(np.where(np.isnan(values), self.worst, values), low, high)
        return CHART_HEIGHT * (high - inside) / (high - low)

    def off(self) -> list[bool]:
        """Return which values are off the axis: their markers stand at its end."""
        low, high = sorted((self.worst, self.best))
        return [not low <= value <= high for value in self.values.tolist()]


def draw(result: ipcore.FitResult) -> tuple[str, LegendEntries]:
    """Return the charts, with their upper left corner at the origin, and the entries of their legend."""
    degrees = np.array([step.degree for step in result.steps])
    across = LEFT + (degrees - degrees[0] + 0.5) * (CHART_WIDTH - LEFT) / (degrees[-1] - degrees[0] + 1)
    chosen = [step.degree == result.degree for step in result.steps]
    parts = [
        f'<g id="{chart.name}" transform="translate(0 {top:g})">\n{_chart(chart, across, chosen)}\n</g>'
        for chart, top in zip((_distance(result), _smoothness(result)), TOPS, strict=True)
    ]
    parts.append(_degrees(degrees, across, result.degree))
    legend = [(TRIED, "tried"), (CHOSEN + TRIED, "chosen"), (ENOUGH, "good enough")]
    return "\n".join(parts), legend


def _distance(result: ipcore.FitResult) -> Chart:
    t1 = result.options.t1
    with np.errstate(divide="ignore", invalid="ignore"):
        *values, threshold = np.log10([step.d_dist for step in result.steps] + [t1]).tolist()
    shown = np.clip([value for value in (*values, threshold) if np.isfinite(value)] or [-1.0], *DECADES)
    low, high = floor(shown.min()), ceil(shown.max())
    high = max(high, low + 1)
    step = ceil((high - low) / MOST_DECADES)
    ticks = [(float(k), _power_of_ten(k)) for k in range(low, high + 1, step)]
    heading = "D_dist — distance from the data, in mean radii"
    return Chart("d_dist", heading, np.array(values), threshold, f"t1 = {t1:g}", float(high), float(low), ticks)


def _smoothness(result: ipcore.FitResult) -> Chart:
    t2 = result.options.t2
    values = np.array([step.d_smooth for step in result.steps])
    shown = np.clip([t2, *values[np.isfinite(values)]], -1.0, 1.0)
    least = min(float(shown.min()), 0.99)
    step, count = next((s, n) for s in COSINE_STEPS if (n := _count(least, s)) <= MOST_COSINES)
    ticks = [(1.0 - k * step, f"{1.0 - k * step:.3g}") for k in range(count + 1)]
    heading = "D_smooth — cosine between normals and ∇f"
    return Chart("d_smooth", heading, values, t2, f"t2 = {t2:g}", ticks[-1][0], 1.0, ticks)


def _count(least: float, step: float) -> int:
    """Return the number of steps from 1 down to the least value, not counting one that is due to rounding."""
    return ceil((1.0 - least) / step - 1e-9)


def _power_of_ten(k: int) -> str:
    """Return 10^k as text.

    >>> _power_of_ten(-2), _power_of_ten(-12)
    ('0.01', '10⁻¹²')
    """
    return f"{10.0**k:g}" if PLAIN[0] <= k <= PLAIN[1] else "10" + str(k).translate(SUPERSCRIPTS)


def _chart(chart: Chart, across: ipcore.FloatArray, chosen: list[bool]) -> str:
    """Return the SVG of a chart with its top at 0: the area that is good enough, the grid, the line, the markers.

    `across` (k,) are the places of the steps from the left, px; `chosen` marks the step that was delivered.
    """
    down = chart.height(chart.values)
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, down, strict=True))
    return "\n".join(
        [
            f'<text x="{LEFT:g}" y="-9" font-weight="600">{escape(chart.heading)}</text>',
            _good_enough(chart),
            *_grid(chart),
            _threshold(chart),
            f'<polyline points="{line}" fill="none" stroke="{BLUE}" stroke-width="1.8" stroke-linejoin="round"/>',
            *(_marker(*at) for at in zip(across, down, chart.off(), chosen, strict=True)),
        ]
    )


def _good_enough(chart: Chart) -> str:
    top, bottom = sorted(chart.height(np.array([chart.threshold, chart.best])).tolist())
    area = f"M{LEFT:g} {top:.1f}H{CHART_WIDTH:g}V{bottom:.1f}H{LEFT:g}Z"
    return f'<path class="enough" d="{area}" fill="{GREEN}" fill-opacity="0.09"/>'


def _grid(chart: Chart) -> list[str]:
    down = chart.height(np.array([position for position, _ in chart.ticks]))
    return [
        f'<path d="M{LEFT:g} {y:.1f}H{CHART_WIDTH:g}" stroke="{GRID}"/>'
        f'<text x="{LEFT - 8:g}" y="{y + 4:.1f}" text-anchor="end" fill="{QUIET}">{label}</text>'
        for y, (_, label) in zip(down, chart.ticks, strict=True)
    ]


def _threshold(chart: Chart) -> str:
    """Return the SVG of the threshold and its label; nothing if it is off the axis."""
    low, high = sorted((chart.worst, chart.best))
    if not low <= chart.threshold <= high:
        return ""
    (y,) = chart.height(np.array([chart.threshold])).tolist()
    return (
        f'<path class="threshold" d="M{LEFT:g} {y:.1f}H{CHART_WIDTH:g}" {DASHED}/>'
        f'<text x="{CHART_WIDTH + 6:g}" y="{y + 4:.1f}" fill="{GREEN}">{escape(chart.label)}</text>'
    )


def _marker(x: float, y: float, off: bool, chosen: bool) -> str:  # noqa: FBT001 - two properties of a marker
    at = f'cx="{x:.1f}" cy="{y:.1f}"'
    paint = f'fill="#fff" stroke="{BLUE}" stroke-width="1.5" stroke-dasharray="2 1.5"' if off else f'fill="{BLUE}"'
    ring = f'<circle class="chosen" {at} r="7" fill="none" stroke="{BLUE}" stroke-width="1.6"/>' if chosen else ""
    return f'<circle class="step" {at} r="3" {paint}/>{ring}'


def _degrees(degrees: ipcore.IntArray, across: ipcore.FloatArray, chosen: int) -> str:
    """Return the axis of degrees that both charts share: evenly spaced labels, and always that of the chosen degree."""
    every = ceil(len(degrees) / MOST_DEGREES)
    y = TOPS[1] + CHART_HEIGHT
    labels = []
    for degree, x in zip(degrees.tolist(), across, strict=True):
        this = degree == chosen
        if this or (degree % every == 0 and abs(degree - chosen) >= every):
            style = 'font-weight="700"' if this else f'fill="{QUIET}"'
            labels.append(f'<text x="{x:.1f}" y="{y + 18:g}" text-anchor="middle" {style}>{degree}</text>')
    labels.append(f'<text x="{LEFT - 8:g}" y="{y + 18:g}" text-anchor="end" fill="{QUIET}">degree</text>')
    return "\n".join(labels)
