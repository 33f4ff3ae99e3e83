"""How much there is to do in a lane of the queue."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LaneLoad:
    """The fits, and parts of fits, of a lane.

    Attributes
    ----------
    lane
        `short` or `long`: by the predicted time of a fit.
    waiting, running
        How many wait for a worker, and how many run.
    oldest
        Seconds since the oldest of those that wait was accepted; 0 if none waits.

    """

    lane: str
    waiting: int = 0
    running: int = 0
    oldest: float = 0.0
