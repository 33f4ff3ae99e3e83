"""The normalised frame: its origin is the centroid of the points, its unit their mean radius, as for all options."""

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
        The mean radius, in raw units: the length that is 1 in the frame.

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
        """Return raw points (…, d) in the coordinates of the frame, (…, d)."""
        return (raw - self.centre) / self.scale

    def to_raw(self, local: FloatArray) -> FloatArray:
        """Return points (…, d) of the frame in raw coordinates, (…, d)."""
        return self.centre + self.scale * local
