"""The frame and the digest of a checked point set, so that no worker has to work them out again."""

from dataclasses import dataclass
from typing import Self

import numpy as np

import ipcore
from service.jobs.slices import Frame


@dataclass(frozen=True)
class PointSetSummary:
    """The facts about a checked point set that a fit needs. They are stored with the fit as JSON.

    Attributes
    ----------
    planar
        Whether 3D points all lie on one plane.
    frame
        Its normalised frame.
    sha256
        The digest of its points and normals that the fit's result reports.
    incomplete
        How many more points the caller sent, which were left out because a value of theirs was missing.

    """

    planar: bool
    frame: Frame
    sha256: str
    incomplete: int = 0

    @classmethod
    def of(cls, given: ipcore.PointSet, incomplete: int = 0) -> Self:
        """Return the summary of a checked point set, beside which so many points were left out."""
        frame = Frame(tuple(given.frame.centre.tolist()), given.frame.scale)
        return cls(given.planar, frame, given.sha256, incomplete)

    def restored(self, points: ipcore.FloatArray, normals: ipcore.FloatArray | None) -> ipcore.PointSet:
        """Return the checked point set again, from its points and its unit normals or None, (N, d) each."""
        frame = ipcore.Frame(np.array(self.frame.centre), self.frame.scale)
        return ipcore.PointSet(
            np.ascontiguousarray(points),
            None if normals is None else np.ascontiguousarray(normals),
            self.planar,
            frame,
            self.sha256,
            self.incomplete,
        )
