"""A fit as the service knows it, and the one table of its legal transitions."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any

from service.jobs.callback import Callback
from service.jobs.point_set_summary import PointSetSummary
from service.jobs.requested_options import RequestedOptions
from service.jobs.slices import Frame, Slice


class FitStatus(StrEnum):
    """The status of a fit."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    SUCCESSFUL = "successful"
    FAILED = "failed"
    DISMISSED = "dismissed"

    @property
    def final(self) -> bool:
        """Return whether the fit has ended: no transition leads on from here."""
        return not TRANSITIONS[self]


# running → accepted: its worker died, or the server stopped, and it is to run again; or all of its parts have ended,
# and the fit itself, which has to add their sums, waits for a worker.
TRANSITIONS: dict[FitStatus, frozenset[FitStatus]] = {
    FitStatus.ACCEPTED: frozenset({FitStatus.RUNNING, FitStatus.DISMISSED}),
    FitStatus.RUNNING: frozenset(
        {FitStatus.SUCCESSFUL, FitStatus.FAILED, FitStatus.DISMISSED, FitStatus.ACCEPTED},
    ),
    FitStatus.SUCCESSFUL: frozenset(),
    FitStatus.FAILED: frozenset(),
    FitStatus.DISMISSED: frozenset(),
}


# Predicted seconds up to which a fit is short. The prediction is an upper estimate: this much is predicted for a fit of
# 100,000 points in 2D up to the default degree.
SHORT_SECONDS = 15.0
# A fit fails when so many of its worker processes have died: one that killed two would kill a third.
MAX_CRASHES = 2
# A fit fails when so many of the processes that supervised it have died. They die for many reasons, but a fit that
# kills each of them must not do so for ever.
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
class ReceivedPoints:
    """A point set that came with a request: it is read and checked, but not stored yet.

    Attributes
    ----------
    content
        An npy file of doubles: (N, d) points, or (N, 2d) points and unit normals.
    key
        SHA-256 of the content, under which it will be stored.
    dimension, points
        d and N.
    normals
        Whether the points come with normals.
    options
        The options in the same body, by name, unchecked.
    summary
        Its frame and its digest, worked out when it was checked.
    left_out
        The number of points that were left out because a value of theirs was missing.

    """

    content: bytes
    key: str
    dimension: int
    points: int
    normals: bool
    options: dict[str, Any]
    summary: PointSetSummary
    left_out: int = 0

    @property
    def frame(self) -> Frame | None:
        """Return the frame in which parts of the points can be summed; None without normals or on a plane."""
        return self.summary.frame if self.normals and not self.summary.planar else None


@dataclass(frozen=True)
class PointSetRef:
    """A point set that was read, checked and stored.

    Attributes
    ----------
    key
        The key of its blob, an npy file of doubles: (N, d) points, or (N, 2d) points and unit normals.
    dimension, points
        d and N.
    size
        Bytes of the blob.
    summary
        Its frame and its digest, worked out when it was checked; None if version 0.1 stored it.

    """

    key: str
    dimension: int
    points: int
    size: int = 0
    summary: PointSetSummary | None = None


@dataclass(frozen=True)
class Fit:
    """One fit, or a part of one: it has the same transitions, and its result are the moments of a slice of the points.

    Attributes
    ----------
    requested
        The options, as the caller gave them.
    client
        Who sent it: the queue is fair between clients.
    owner
        The name of the API key to which it belongs; empty if it was sent without one.
    cost
        Predicted seconds.
    key, payload
        The idempotency key of its request, and a hash of its point set and options.
    attempt
        How often it was started: 0 before the first time. Only the latest attempt may end the fit.
    crashes
        How often its worker process died.
    result
        The result as JSON, or a part's moments as npz, when successful.
    failure
        Why it failed, when failed.
    parts, unsummed
        For a fit that was split: the number of its parts, and of those that have not ended yet. The fit itself is not
        queued before all have.
    callback
        Who is to be told of its end, if anybody.
    whole, slice
        For a part: the id of the fit that it belongs to, and the slice of the points that it sums.

    """

    id: str
    status: FitStatus
    input: PointSetRef
    requested: RequestedOptions
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
    owner: str = ""
    callback: Callback | None = None

    @property
    def lane(self) -> str:
        """Return the name of the lane for which it waits."""
        return "short" if self.short else "long"

    @property
    def short(self) -> bool:
        """Return whether it may run in the lane of short fits. Parts may not: together they take long."""
        return self.whole is None and self.cost <= SHORT_SECONDS
