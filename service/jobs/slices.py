"""Which of its points a part of a fit is about."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Frame:
    """The normalised frame of a point set. Moments add only in the same frame, to the last bit: it is worked out once.

    Attributes
    ----------
    centre, scale
        The centroid (d,), and the mean distance to it, in raw units.

    """

    centre: tuple[float, ...]
    scale: float


@dataclass(frozen=True)
class Slice:
    """Some points of a set, from row `first` to before row `last`, and the frame of the set."""

    first: int
    last: int
    frame: Frame
