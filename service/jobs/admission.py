"""Who may add a fit to the queue now: the limits of the queue, and each caller's share of it."""

from dataclasses import dataclass, replace
from typing import Self

from service.jobs.caller import Quota
from service.jobs.errors import QueueFullError, QuotaExceededError

# Seconds after which a caller is told to try again, at most, when the queue is full. The predicted time of a fit is an
# upper estimate, and most fits stop early.
LONGEST_RETRY = 30.0
HOUR = 3600.0


@dataclass(frozen=True)
class Usage:
    """What waits, and what one caller has of it.

    Attributes
    ----------
    waiting, seconds, size
        How many fits wait for a worker, the predicted seconds of all of them, and the bytes of their points.
    own_waiting, own_seconds
        How many of them are the caller's, and their predicted seconds.
    recent
        How many fits of the caller were accepted in the last hour.
    oldest_age
        Seconds since the first of those; 0 if there are none.

    """

    waiting: int
    seconds: float
    size: int
    own_waiting: int
    own_seconds: float
    recent: int
    oldest_age: float


@dataclass(frozen=True)
class Allowance:
    """What a caller may still send, for the fields RateLimit and RateLimit-Policy.

    Attributes
    ----------
    name
        Of the quota: `waiting` or `hourly`.
    quota, remaining
        How many fits in all, and how many more now.
    window, reset
        Seconds for which the quota is, and after which there will be more; None where they depend on the work.

    """

    name: str
    quota: int
    remaining: int
    reset: float
    window: float | None = None

    def after_one(self) -> Self:
        """Return what is left after one more fit."""
        return replace(self, remaining=max(0, self.remaining - 1))


@dataclass(frozen=True)
class Admission:
    """The limits of the queue.

    Attributes
    ----------
    places
        Fits that may wait.
    size
        Bytes that their points may take on disk together.
    share
        The share of the places that one caller may have, unless the caller's quota says otherwise.

    """

    places: int
    size: int = 2**63
    share: float = 1.0

    def has_much_room(self, usage: Usage) -> bool:
        """Return whether less than half of the places and of the bytes are taken.

        >>> limits, nobody = Admission(10, size=100), (0, 0.0, 0, 0.0)
        >>> [limits.has_much_room(Usage(*taken, *nobody)) for taken in ((4, 9.0, 49), (5, 9.0, 0), (0, 0.0, 50))]
        [True, False, False]
        """
        return 2 * usage.waiting < self.places and 2 * usage.size < self.size

    def allowances(self, usage: Usage, quota: Quota) -> list[Allowance]:
        """Return what a caller may still send."""
        places = quota.waiting if quota.waiting is not None else max(1, int(self.share * self.places))
        pause = _pause(usage.own_seconds, usage.own_waiting)
        found = [Allowance("waiting", places, max(0, places - usage.own_waiting), pause)]
        if quota.hourly is not None:
            left = max(0, quota.hourly - usage.recent)
            found.append(Allowance("hourly", quota.hourly, left, HOUR - min(usage.oldest_age, HOUR), HOUR))
        return found

    def check(self, usage: Usage, quota: Quota) -> None:
        """Refuse one more fit if there is no room for it.

        Raises
        ------
        QueueFullError
            If the queue or its disk is full.
        QuotaExceededError
            If the caller has used up a quota.

        """
        pause = _pause(usage.seconds, usage.waiting)
        if usage.waiting >= self.places:
            raise QueueFullError(f"{usage.waiting} fits wait already, as many as may", retry_after=pause)
        if usage.size >= self.size:
            raise QueueFullError(f"the points of fits that wait take {usage.size} bytes already", retry_after=pause)
        allowances = self.allowances(usage, quota)
        spent = next((one for one in allowances if not one.remaining), None)
        if spent is not None:
            what = "wait" if spent.name == "waiting" else "were accepted within an hour"
            raise QuotaExceededError(f"{spent.quota} fits of yours {what}, as many as may", allowances, spent.reset)


def _pause(seconds: float, count: int) -> float:
    """Return the seconds after which one of so many waiting fits will probably have been started."""
    return max(1.0, min(seconds / count, LONGEST_RETRY)) if count else 1.0
