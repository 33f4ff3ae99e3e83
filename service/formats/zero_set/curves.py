"""Curves as SVG, to look at, and as GeoJSON, to compute with. The inside is on the left of every line."""

import numpy as np
import orjson

from ipcore._typing import FloatArray
from ipcore.zero_set.zero_set import ZeroSet

MARGIN = 0.05  # of the longer side, on each side of a picture: wider than any stroke

SVG = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" data-origin="{x} {y}">
<desc>Zero set f = 0. The path's coordinates are those of the data minus ({x}, {y}); y points up.</desc>
<path transform="scale(1 -1)" d="{path}" fill="none" fill-rule="evenodd" stroke="currentColor" stroke-width="1.5" \
stroke-linejoin="round" vector-effect="non-scaling-stroke"/>
</svg>
"""


def svg(curve: ZeroSet) -> bytes:
    """Return an SVG picture: one path, y up, with a stroke of 1.5 pixels at any size.

    Programs that show SVG compute in float32, so the path is drawn about the middle of the curve; `data-origin` has
    what to add to get the data's coordinates. To fill the inside, set `fill`: the rule is even-odd.
    """
    lines = curve.polylines()
    lower, upper = _corners(curve.vertices)
    middle, sides = (lower + upper) / 2.0, upper - lower
    half = sides / 2.0 + MARGIN * (float(sides.max()) or 1.0)
    box = "{:.7g} {:.7g} {:.7g} {:.7g}".format(*-half, *(2.0 * half))
    x, y = middle.tolist()
    return SVG.format(box=box, x=x, y=y, path="".join(_subpath(line - middle) for line in lines)).encode("ascii")


def geojson(curve: ZeroSet) -> bytes:
    """Return a GeoJSON Feature with exact coordinates: a (Multi)Polygon if all lines are closed, else lines.

    A ring round the inside is an outer ring, and winds counter-clockwise; one round a hole winds clockwise and goes
    with the smallest outer ring round it: the right-hand rule of RFC 7946, 3.1.6. The coordinates are plain numbers of
    the data, not longitude and latitude, for which RFC 7946 (section 4) asks for agreement: here it is.
    """
    feature: dict[str, object] = {
        "type": "Feature",
        "geometry": _geometry(curve.polylines()),
        "properties": {
            "coordinates": "those of the data, no coordinate reference system",
            "components": curve.components,
            "stray": curve.stray,
        },
    }
    if len(curve.cells):
        feature["bbox"] = np.concatenate(_corners(curve.vertices))
    return orjson.dumps(feature, option=orjson.OPT_SERIALIZE_NUMPY)


def _corners(vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the lower and the upper corner (2,) of the vertices' box; the origin if there are none."""
    return (vertices.min(axis=0), vertices.max(axis=0)) if len(vertices) else (np.zeros(2), np.zeros(2))


def _subpath(line: FloatArray) -> str:
    closed = bool((line[0] == line[-1]).all())
    body = "L".join(f"{x:.7g} {y:.7g}" for x, y in (line[:-1] if closed else line).tolist())
    return f"M{body}" + "Z" * closed


def _geometry(lines: list[FloatArray]) -> dict[str, object] | None:
    if not lines:
        return None
    polygons = _polygons(lines) if all((line[0] == line[-1]).all() for line in lines) else None
    if polygons is None:
        return {"type": "MultiLineString", "coordinates": lines}
    if len(polygons) > 1:
        return {"type": "MultiPolygon", "coordinates": polygons}
    return {"type": "Polygon", "coordinates": polygons[0]}


def _polygons(rings: list[FloatArray]) -> list[list[FloatArray]] | None:
    """Return the outer rings, each with its holes behind it; None if a hole lies in no outer ring."""
    outer = sorted((ring for ring in rings if _area(ring) > 0.0), key=_area)
    polygons = [[ring] for ring in outer]
    for hole in (ring for ring in rings if _area(ring) <= 0.0):
        around = [polygon for polygon in polygons if _within(hole[0], polygon[0])]
        if not around:
            return None
        around[0].append(hole)
    return polygons


def _area(ring: FloatArray) -> float:
    """Return the area within a closed ring (n, 2), negative if it winds clockwise (the shoelace formula)."""
    x, y = (ring - ring[0]).T
    return float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) / 2.0


def _within(point: FloatArray, ring: FloatArray) -> bool:
    """Return whether a point (2,) is within a closed ring (n, 2): a ray to the right crosses it oddly often."""
    (x0, y0), (x1, y1) = (ring[:-1] - point).T, (ring[1:] - point).T
    crosses = (y0 > 0.0) != (y1 > 0.0)
    right = (x0 * y1 - x1 * y0) * (y1 - y0) > 0.0  # the crossing's x is (x0 y1 − x1 y0)/(y1 − y0)
    return bool(np.count_nonzero(crosses & right) % 2)
