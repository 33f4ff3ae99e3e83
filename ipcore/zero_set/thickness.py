"""How thick the inside and the outside are where a grid has found the zero set, compared with a cell of the grid.

A part that is thinner than a few cells lies between the nodes of the grid in places: it comes out too small, in pieces,
or not at all. So from some places on f = 0, evenly spaced in the list of cells, f is evaluated a few cells inward and
outward along the normal. A place is *thin* if f does not have the sign there that it has beside the zero set.
"""

import numpy as np

from ipcore._typing import BoolArray, FloatArray
from ipcore.polynomial.implicit import ImplicitPolynomial
from ipcore.zero_set.newton import onto_zero_set
from ipcore.zero_set.support import is_beyond_support

# The thickness in cells below which a place is thin, and the share of thin places up to which a zero set counts as
# resolved: every tip and edge is thin. Ellipsoids of 20 : 1 : 1, 50 : 1 : 1 and 50 : 50 : 1, turned or not, then have
# at least 97.9 % of their volume; with 3 cells some have 96 %.
THIN_CELLS = 4.0
TOLERATED_THIN = 0.15
PLACES = 256  # the share of thin ones is off by 1/50; these take 5 % of the time of a mesh


def thin_share(
    polynomial: ImplicitPolynomial,
    places: FloatArray,
    spacing: float,
    bounds: FloatArray,
    data: FloatArray | None = None,
) -> float:
    """Return the share of thin places, of `PLACES` at most.

    Parameters
    ----------
    polynomial
        f.
    places
        (M, d), raw, M ≥ 1, within a grid cell of f = 0.
    spacing
        The side of a grid cell, raw.
    bounds
        (2, d), the corners of the box, raw; beyond it f is not looked at.
    data
        (N, d), raw: places beyond their support radius do not count, if there are others; None if all count.

    Examples
    --------
    >>> from ipcore import shapes
    >>> ring, _ = shapes.circle().sample(100)
    >>> [thin_share(shapes.circle().polynomial, ring, h, np.array([[-3.0, -3.0], [3.0, 3.0]])) for h in (0.49, 0.51)]
    [0.0, 1.0]

    """
    some = places[:: 1 + len(places) // PLACES]
    if data is not None and not (beyond := is_beyond_support(some, data)).all():
        some = some[~beyond]
    x, normals = onto_zero_set(polynomial, some, spacing)
    return float(is_thin(polynomial, x, normals, THIN_CELLS * spacing, bounds).mean())


def is_thin(
    polynomial: ImplicitPolynomial, x: FloatArray, normals: FloatArray, thickness: float, bounds: FloatArray
) -> BoolArray:
    """Return whether the inside or the outside is thinner than `thickness`, raw, at places x (M, d) on f = 0, (M,).

    `normals` (M, d) are the unit normals there, 0 where nothing is known.
    """
    thin = np.zeros(len(x), dtype=bool)
    for depth in (thickness / 2.0, thickness):
        for side in (-1.0, 1.0):
            y = x + side * depth * normals
            within = ((y >= bounds[0]) & (y <= bounds[1])).all(axis=1)
            thin |= within & (side * polynomial(y) <= 0.0) & normals.any(axis=1)
    return thin
