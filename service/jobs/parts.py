"""A huge fit in parts: each sums the moments of some of the points; the fit adds them up and goes on from there."""

from dataclasses import replace
from math import ceil

from service.jobs.fit import Fit
from service.jobs.slices import Frame, Slice


def split(fit: Fit, frame: Frame, most: int) -> tuple[Fit, list[Fit]]:
    """Return a new fit as one of parts, and its parts, of at most so many points each, and of equally many.

    Each takes its share of the predicted time; what is left for the fit itself, to look at every degree and to refine
    it on all points, may take as long once more. The ids of the parts sort as their points do.

    >>> from datetime import UTC, datetime
    >>> from service.jobs.fit import FitStatus, PointSetRef
    >>> from service.jobs.requested_options import RequestedOptions
    >>> fit = Fit("a", FitStatus.ACCEPTED, PointSetRef("", 3, 1000), RequestedOptions({}), datetime.now(UTC), cost=9.0)
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
