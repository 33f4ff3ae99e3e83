"""What single precision can hold: the numbers of STL and GLB files."""

import numpy as np

import ipcore
from service.jobs.errors import InvalidInputError

LARGEST, SMALLEST = float(np.finfo(np.float32).max), float(np.finfo(np.float32).tiny)
# The step between neighbouring numbers, as a share of the surface's extent, above which a file would show it.
COARSEST = 1e-4
STEP = float(np.finfo(np.float32).eps)


def check(surface: ipcore.ZeroSet, kind: str, *, about: ipcore.FloatArray | None = None) -> None:
    """Check that the vertices can be written as numbers of single precision, about a point (3,) or the origin.

    Raises
    ------
    InvalidInputError
        If they are too large or too small for it, or if its steps are too coarse so far from the origin.

    """
    if not len(surface.vertices):
        return
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    extent, largest = float((high - low).max()), float(np.abs([low, high]).max())
    written = largest if about is None else extent
    if not extent > SMALLEST / STEP or largest > LARGEST:
        reason = f"coordinates as large as {largest:.3g} over an extent of {extent:.3g} are out of their range"
    elif STEP * written > COARSEST * extent:
        reason = f"at coordinates of {largest:.3g} their steps are too coarse for an extent of {extent:.3g}"
    else:
        return
    raise InvalidInputError(
        f"{kind} files have numbers of single precision, and {reason}: take ply or obj, which have doubles", ("format",)
    )
