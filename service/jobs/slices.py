"""A slice of a point set, and the frame in which its moments are summed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Frame:
    """The normalised frame of a point set, as plain numbers.

    It is worked out once for the whole set: moments of two slices add only if their frames are equal to the last bit.

    Attributes
    ----------
    centre, scale
        The centroid (d,), and the mean distance of the points from it, in raw units.

    """

    centre: tuple[float, ...]
    scale: float


@dataclass(frozen=True)
class Slice:
    """The points of a set from row `first` to before row `last`, and the frame of the set."""

    first: int
    last: int
    frame: Frame
