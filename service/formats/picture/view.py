"""The direction from which a surface is seen."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

import ipcore


@dataclass(frozen=True)
class View:
    """The direction from which a surface is seen, in parallel projection.

    Attributes
    ----------
    up
        The axis that points up: y, as in glTF and for most scanned models, or z, as in mathematics and CAD.
    azimuth
        Degrees to the right of the front, which is +z when y is up and −y when z is up.
    elevation
        Degrees above the horizon.

    """

    up: Literal["y", "z"] = "y"
    azimuth: float = 30.0
    elevation: float = 20.0

    def axes(self) -> ipcore.FloatArray:
        """Return the unit vectors to the right, up and towards the eye, the rows of a rotation (3, 3).

        >>> View("z", azimuth=0.0, elevation=0.0).axes().round().astype(int).tolist()
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
        """
        x, y, z = np.eye(3)
        up, front = (y, z) if self.up == "y" else (z, -y)
        a, e = np.radians([self.azimuth, self.elevation])
        right = np.cos(a) * x - np.sin(a) * front
        towards = np.cos(e) * (np.sin(a) * x + np.cos(a) * front) + np.sin(e) * up
        return np.stack([right, np.cross(towards, right), towards])
