"""A picture of a fit: its shape on the left, how its degree was found on the right."""

from html import escape

import ipcore
from service.formats.picture import trace
from service.formats.picture.plane import LegendEntries, curve
from service.formats.picture.surface import View, surface

# A white card with dark text of its own, so that it reads the same on light and on dark pages.
SVG = """\
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
LEFT, RIGHT, TOP = 32, 526, 66  # px, where the halves begin
LEGEND = 494  # px, its baseline
CHARACTER = 6.3  # px, how wide one is on average at 12 px in the widest of the fonts


def plot(result: ipcore.FitResult, points: ipcore.FloatArray, view: View | None = None) -> bytes:
    """Return an SVG picture, 960 px wide, that needs nothing beside itself.

    Parameters
    ----------
    result
        What `ipcore.fit` returned.
    points
        (N, d), raw, as they were fitted.
    view
        Which axis is up and from where a surface is seen; curves ignore it.

    """
    facts = _facts(result)
    flat = points.shape[1] == 2
    shape, shape_legend = (
        curve(result.polynomial, points) if flat else surface(result.polynomial, points, view or View())
    )
    history, trace_legend = trace.draw(result)
    return SVG.format(
        left=LEFT,
        right=RIGHT,
        top=TOP,
        title=escape(f"Implicit polynomial of {facts[0]}"),
        description=escape(_description(result, points)),
        degree=escape(facts[0]),
        facts=escape("".join(f" · {fact}" for fact in facts[1:])),
        shape=shape,
        trace=history,
        shape_legend=_legend(LEFT, shape_legend),
        trace_legend=_legend(RIGHT + trace.LEFT, trace_legend),
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
    """Return symbols, drawn about the origin, and their labels from x on."""
    parts = []
    for symbol, label in entries:
        parts.append(
            f'<g transform="translate({x + 8:.0f} {LEGEND - 4})">{symbol}</g>'
            f'<text x="{x + 22:.0f}" y="{LEGEND}">{escape(label)}</text>'
        )
        x += 40 + CHARACTER * len(label)
    return "\n".join(parts)
