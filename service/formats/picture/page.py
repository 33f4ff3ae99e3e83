"""The whole picture of a fit: its shape on the left, the measures of every degree on the right."""

from html import escape

import ipcore
from service.formats.picture import trace
from service.formats.picture.plane import LegendEntries, curve
from service.formats.picture.surface import surface
from service.formats.picture.view import View

# A white card with dark text, so that it looks the same on light and on dark pages.
PAGE_SVG = """\
<svg xmlns="http://www.w3.org/2000/svg" width="960" height="520" viewBox="0 0 960 520" role="img" fill="#1f2933" \
font-family="system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif" font-size="12">
<title>{title}</title>
<desc>{description}</desc>
<rect x="0.5" y="0.5" width="959" height="519" rx="14" fill="#fff" stroke="#d5dbe1"/>
<text id="headline" x="{left}" y="41" font-size="17"><tspan font-weight="600">{degree}</tspan>{facts}</text>
<g id="shape" transform="translate({left} {top})">
{shape}
</g>
<g id="trace" transform="translate({right} {top})">
{trace}
</g>
<g id="legend" fill="#52606d">
{shape_legend}
{trace_legend}
</g>
</svg>
"""
HALF_LEFT, HALF_RIGHT, HALF_TOP = 32, 526, 66  # px, the left ends of the two halves and their top
LEGEND = 494  # px, the baseline of the legend
CHARACTER = 6.3  # px, the mean width of a character at 12 px in the widest of the fonts


def plot(result: ipcore.FitResult, points: ipcore.FloatArray, view: View | None = None) -> bytes:
    """Return an SVG picture, 960 px wide, without references to other files.

    Parameters
    ----------
    result
        The result of `ipcore.fit`.
    points
        (N, d), raw: the points that were fitted.
    view
        The direction from which a surface is seen; not used for curves.

    """
    facts = _facts(result)
    flat = points.shape[1] == 2
    shape, shape_legend = (
        curve(result.polynomial, points) if flat else surface(result.polynomial, points, view or View())
    )
    history, trace_legend = trace.draw(result)
    return PAGE_SVG.format(
        left=HALF_LEFT,
        right=HALF_RIGHT,
        top=HALF_TOP,
        title=escape(f"Implicit polynomial of {facts[0]}"),
        description=escape(_description(result, points)),
        degree=escape(facts[0]),
        facts=escape("".join(f" · {fact}" for fact in facts[1:])),
        shape=shape,
        trace=history,
        shape_legend=_legend(HALF_LEFT, shape_legend),
        trace_legend=_legend(HALF_RIGHT + trace.LEFT, trace_legend),
    ).encode()


def _facts(result: ipcore.FitResult) -> list[str]:
    return [
        f"degree {result.degree}",
        f"{len(result.polynomial.coefficients)} coefficients",
        f"D_dist {result.diagnostics.d_dist:.2g}",
        f"D_smooth {result.diagnostics.d_smooth:.3f}",
        str(result.stop_reason),
    ]


def _description(result: ipcore.FitResult, points: ipcore.FloatArray) -> str:
    kind = {2: "curve", 3: "surface"}[result.polynomial.dimension]
    tried = ", ".join(f"{step.degree}: {step.d_dist:.2g} and {step.d_smooth:.3f}" for step in result.steps)
    return (
        f"Left: the {kind} f = 0 and the {len(points)} data points it was fitted to. Right: closeness D_dist and "
        f"smoothness D_smooth of every degree that was tried ({tried}), with the thresholds "
        f"{result.options.t1:g} and {result.options.t2:g}. {result.stop_reason.advice}"
    )


def _legend(x: float, entries: LegendEntries) -> str:
    """Return a legend that starts at x, px; the symbols of its entries are drawn about the origin."""
    parts = []
    for symbol, label in entries:
        parts.append(
            f'<g transform="translate({x + 8:.0f} {LEGEND - 4})">{symbol}</g>'
            f'<text x="{x + 22:.0f}" y="{LEGEND}">{escape(label)}</text>'
        )
        x += 40 + CHARACTER * len(label)
    return "\n".join(parts)
