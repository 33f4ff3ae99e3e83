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

    """

    planar: bool
    frame: Frame
    sha256: str

    @classmethod
    def of(cls, given: ipcore.PointSet) -> Self:
        """Return the summary of a checked point set."""
        return cls(given.planar, Frame(tuple(given.frame.centre.tolist()), given.frame.scale), given.sha256)

    def restored(self, points: ipcore.FloatArray, normals: ipcore.FloatArray | None) -> ipcore.PointSet:
        """Return the checked point set again, from its points and its unit normals or None, (N, d) each."""
        frame = ipcore.Frame(np.array(self.frame.centre), self.frame.scale)
        return ipcore.PointSet(
            np.ascontiguousarray(points),
            None if normals is None else np.ascontiguousarray(normals),
            self.planar,
            frame,
            self.sha256,
        )
