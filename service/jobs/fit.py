"""A fit as the service knows it, and the one table of its legal moves."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any

from service.jobs.cost import SHORT
from service.jobs.slices import Frame, Slice


class FitStatus(StrEnum):
    """Where a fit is in its life."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    SUCCESSFUL = "successful"
    FAILED = "failed"
    DISMISSED = "dismissed"

    @property
    def final(self) -> bool:
        """Return whether nothing can happen to the fit any more."""
        return not TRANSITIONS[self]


# running → accepted: its worker died, or the server stopped, and it is to run again; or all of its parts have ended,
# and what is left of it waits for a worker.
TRANSITIONS: dict[FitStatus, frozenset[FitStatus]] = {
    FitStatus.ACCEPTED: frozenset({FitStatus.RUNNING, FitStatus.DISMISSED}),
    FitStatus.RUNNING: frozenset(
        {FitStatus.SUCCESSFUL, FitStatus.FAILED, FitStatus.DISMISSED, FitStatus.ACCEPTED},
    ),
    FitStatus.SUCCESSFUL: frozenset(),
    FitStatus.FAILED: frozenset(),
    FitStatus.DISMISSED: frozenset(),
}


# A fit whose worker process died is started once more: what kills two would kill a third.
MAX_CRASHES = 2
# A fit whose supervisor died is taken over by another one so often: supervisors die for many reasons, but a fit that
# brings each of them down must not do so for ever.
MAX_ABANDONED = 5


def sources(target: FitStatus) -> list[FitStatus]:
    """Return the statuses from which a fit may move to `target`.

    >>> [str(status) for status in sources(FitStatus.DISMISSED)]
    ['accepted', 'running']
    """
    return [status for status, targets in TRANSITIONS.items() if target in targets]


@dataclass(frozen=True)
class Failure:
    """Why a fit failed.

    Attributes
    ----------
    kind
        A stable word: `worker-crashed`, `deadline-exceeded`, `out-of-memory`, `fit-error`.
    detail
        One sentence.

    """

    kind: str
    detail: str


@dataclass(frozen=True)
class PointSet:
    """A point set that was read and checked, not yet stored.

    Attributes
    ----------
    content
        An npy file of doubles: (N, d) points, or (N, 2d) points and unit normals.
    dimension, points
        d and N.
    options
        What came along in the same body, unchecked.
    frame
        Its frame, if it has normals and is not planar: then sums over its points can be made part by part.
    left_out
        Points that were left out because a value of theirs was missing.

    """

    content: bytes
    dimension: int
    points: int
    options: dict[str, Any]
    frame: Frame | None = None
    left_out: int = 0


@dataclass(frozen=True)
class PointSetRef:
    """A point set that was read, checked and stored.

    Attributes
    ----------
    key
        Of the blob: an (N, d) npy of points, or (N, 2d) of points and normals, doubles.
    dimension, points
        d and N.
    size
        Its bytes.

    """

    key: str
    dimension: int
    points: int
    size: int = 0


@dataclass(frozen=True)
class Holder:
    """Who runs fits, and for how long the store believes it without hearing from it again.

    Attributes
    ----------
    name
        Of the supervisor, unique.
    lease
        Seconds.

    """

    name: str
    lease: float


@dataclass(frozen=True)
class Fit:
    """One fit; or a part of one, which lives as fits do, and whose result are the moments of some of the points.

    Attributes
    ----------
    options
        What was asked for, by option name; defaults are not filled in.
    client
        Who sent it; the queue is fair between clients.
    cost
        Predicted seconds.
    key, payload
        The idempotency key that came with it, and a hash of what is to be fitted and how.
    attempt
        How often it was started: 0 while it waits for the first time. Only the latest attempt may end the fit.
    crashes
        How often its worker process died.
    result
        JSON of the answer, when successful.
    failure
        Why, when failed.
    parts, unsummed
        Of a fit that was split: how many parts it has, and how many of them have not ended yet. Until all have, it is
        not in line itself.
    whole, slice
        Of a part: the fit that it belongs to, and its points.

    """

    id: str
    status: FitStatus
    input: PointSetRef
    options: dict[str, Any]
    created: datetime
    client: str = ""
    cost: float = 0.0
    key: str | None = None
    payload: str = ""
    started: datetime | None = None
    finished: datetime | None = None
    attempt: int = 0
    crashes: int = 0
    result: bytes | None = None
    failure: Failure | None = None
    parts: int = 0
    unsummed: int = 0
    whole: str | None = None
    slice: Slice | None = None

    @property
    def short(self) -> bool:
        """Return whether it may use the lane of the short. The parts of a huge fit must not: together they are long."""
        return self.whole is None and self.cost <= SHORT
