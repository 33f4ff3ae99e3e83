"""Splitting the fit of a huge point set into parts.

A part sums the moments of a slice of the points. When all parts have ended, the fit itself runs: it adds their moments
and fits.
"""

from dataclasses import replace
from math import ceil

from service.jobs.fit import Fit
from service.jobs.slices import Frame, Slice


def split(fit: Fit, frame: Frame, most: int) -> tuple[Fit, list[Fit]]:
    """Return a new fit, marked as having parts, and its parts, of equally many points each and at most `most`.

    Each part gets its share of the predicted time of the fit. The fit itself keeps all of it, for what remains to do
    after the sums: it may look at every degree on all points. The ids of the parts sort in the order of their slices.

    >>> from datetime import UTC, datetime
    >>> from service.jobs.fit import FitStatus, PointSetRef
    >>> from service.jobs.requested_options import RequestedOptions
    >>> given = PointSetRef("", 3, 1000)
    >>> fit = Fit("a", FitStatus.ACCEPTED, given, RequestedOptions({}), datetime.now(UTC), cost=9.0)
    >>> whole, parts = split(fit, Frame((0.0, 0.0, 0.0), 1.0), 400)
    >>> whole.unsummed, [(one.id, one.slice.first, one.slice.last, one.cost) for one in parts]
    (3, [('a-00000', 0, 333, 3.0), ('a-00001', 333, 666, 3.0), ('a-00002', 666, 1000, 3.0)])
    """
    points = fit.input.points
    count = ceil(points / most)
    edges = [points * i // count for i in range(count + 1)]
    part = replace(fit, key=None, whole=fit.id, cost=fit.cost / count, input=replace(fit.input, size=0))
    parts = [replace(part, id=f"{fit.id}-{i:05d}", slice=Slice(edges[i], edges[i + 1], frame)) for i in range(count)]
    return replace(fit, parts=count, unsummed=count), parts
