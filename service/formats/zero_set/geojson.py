"""GeoJSON: the exact coordinates of a curve, with the inside on the left of every line."""

import numpy as np
import orjson

import ipcore
from service.formats.zero_set.box import corners


def write(curve: ipcore.ZeroSet) -> bytes:
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
        feature["bbox"] = np.concatenate(corners(curve.vertices))
    return orjson.dumps(feature, option=orjson.OPT_SERIALIZE_NUMPY)


def _geometry(lines: list[ipcore.FloatArray]) -> dict[str, object] | None:
    """Return the GeoJSON geometry of lines (n, 2) each; None if there are none."""
    if not lines:
        return None
    polygons = _polygons(lines) if all((line[0] == line[-1]).all() for line in lines) else None
    if polygons is None:
        return {"type": "MultiLineString", "coordinates": lines}
    if len(polygons) > 1:
        return {"type": "MultiPolygon", "coordinates": polygons}
    return {"type": "Polygon", "coordinates": polygons[0]}


def _polygons(rings: list[ipcore.FloatArray]) -> list[list[ipcore.FloatArray]] | None:
    """Return polygons: each an outer ring and then its holes, (n, 2) each; None if a hole lies in no outer ring."""
    outer = sorted((ring for ring in rings if _area(ring) > 0.0), key=_area)
    polygons = [[ring] for ring in outer]
    for hole in (ring for ring in rings if _area(ring) <= 0.0):
        around = [polygon for polygon in polygons if _within(hole[0], polygon[0])]
        if not around:
            return None
        around[0].append(hole)
    return polygons


def _area(ring: ipcore.FloatArray) -> float:
    """Return the area within a closed ring (n, 2), negative if it winds clockwise (the shoelace formula)."""
    x, y = (ring - ring[0]).T
    return float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) / 2.0


def _within(point: ipcore.FloatArray, ring: ipcore.FloatArray) -> bool:
    """Return whether a point (2,) is within a closed ring (n, 2).

    It is if a ray from it to the right crosses the ring an odd number of times.
    """
    (x0, y0), (x1, y1) = (ring[:-1] - point).T, (ring[1:] - point).T
    crosses = (y0 > 0.0) != (y1 > 0.0)
    right = (x0 * y1 - x1 * y0) * (y1 - y0) > 0.0  # the crossing's x is (x0 y1 − x1 y0)/(y1 − y0)
    return bool(np.count_nonzero(crosses & right) % 2)
