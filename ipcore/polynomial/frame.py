"""The normalised frame: centred at the centroid, one mean radius long. Distances in options are in its unit."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ipcore._typing import FloatArray


@dataclass(frozen=True, eq=False)
class Frame:
    """A centre and a scale: local = (raw − centre) / scale.

    Attributes
    ----------
    centre
        (d,), raw coordinates.
    scale
        The mean radius, in raw units: what is 1 long in the frame.

    """

    centre: FloatArray
    scale: float

    @classmethod
    def of(cls, points: FloatArray) -> Self:
        """Return the frame of raw points (N, d): centroid, and mean distance to it (section 6, condition 2).

        >>> square = np.array([[0., 0.], [2., 0.], [2., 2.], [0., 2.]])
        >>> frame = Frame.of(square)
        >>> frame.centre.tolist(), round(frame.scale, 4)
        ([1.0, 1.0], 1.4142)
        """
        centre = points.mean(axis=0)
        return cls(centre, float(np.linalg.norm(points - centre, axis=1).mean()))

    def to_local(self, raw: FloatArray) -> FloatArray:
        """Take raw coordinates (…, d) into the frame."""
        return (raw - self.centre) / self.scale

    def to_raw(self, local: FloatArray) -> FloatArray:
        """Take coordinates in the frame (…, d) back to the caller's."""
        return self.centre + self.scale * local
