"""SVG: a picture of a curve, with the inside on the left of every line."""

import ipcore
from service.formats.zero_set.box import corners

MARGIN_SHARE = 0.05  # of the longer side, on each side of the picture: wider than any stroke

CURVE_SVG = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" data-origin="{x} {y}">
<desc>Zero set f = 0. The path's coordinates are those of the data minus ({x}, {y}); y points up.</desc>
<path transform="scale(1 -1)" d="{path}" fill="none" fill-rule="evenodd" stroke="currentColor" stroke-width="1.5" \
stroke-linejoin="round" vector-effect="non-scaling-stroke"/>
</svg>
"""


def write(curve: ipcore.ZeroSet) -> bytes:
    """Return an SVG picture: one path, y up, with a stroke of 1.5 pixels at any size.

    Programs that show SVG compute in float32, so the coordinates of the path are relative to the middle of the curve,
    which stands in `data-origin`. To fill the inside, set `fill`: the rule is even-odd.
    """
    lines = curve.polylines()
    lower, upper = corners(curve.vertices)
    middle, sides = (lower + upper) / 2.0, upper - lower
    half = sides / 2.0 + MARGIN_SHARE * (float(sides.max()) or 1.0)
    box = "{:.7g} {:.7g} {:.7g} {:.7g}".format(*-half, *(2.0 * half))
    x, y = middle.tolist()
    return CURVE_SVG.format(box=box, x=x, y=y, path="".join(_subpath(line - middle) for line in lines)).encode("ascii")


def _subpath(line: ipcore.FloatArray) -> str:
    """Return the SVG path of a line (n, 2); it is closed if its last point is its first."""
    closed = bool((line[0] == line[-1]).all())
    body = "L".join(f"{x:.7g} {y:.7g}" for x, y in (line[:-1] if closed else line).tolist())
    return f"M{body}" + "Z" * closed
