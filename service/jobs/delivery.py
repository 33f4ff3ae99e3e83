"""One try to deliver a callback: what is sent, what the receiver answers, what comes of it."""

from dataclasses import dataclass
from datetime import UTC, datetime

import orjson

from service.jobs.callback import CallbackState
from service.jobs.fit import FitStatus

EVENT = "fit.ended"


class NotDeliveredError(Exception):
    """No answer was received; the message says why, in words that the caller of the fit may read."""


@dataclass(frozen=True)
class Delivery:
    """A callback that is due, and was taken by this process.

    Attributes
    ----------
    fit_id, url, host
        The fit, and where to.
    client
        Who sent the fit.
    status, ended
        How and when the fit ended.
    tries
        The number of this try, from 1.
    last_error
        Why the one before failed.

    """

    fit_id: str
    url: str
    host: str
    client: str
    status: FitStatus
    ended: datetime
    tries: int
    last_error: str | None = None

    @property
    def message_id(self) -> str:
        """Return what names the message: the same in every try, so that a receiver can drop repeats."""
        return f"ended-{self.fit_id}"

    def body(self, path: str) -> bytes:
        """Return the JSON document that is sent, also the same in every try; `path` is that of all fits."""
        data = {"id": self.fit_id, "status": self.status, "path": f"{path}/{self.fit_id}"}
        event = {"type": EVENT, "timestamp": self.ended.astimezone(UTC), "data": data}
        return orjson.dumps(event, option=orjson.OPT_UTC_Z)


@dataclass(frozen=True)
class Answer:
    """What a receiver answered.

    Attributes
    ----------
    status
        The HTTP status.
    retry_after
        Seconds after which it wants to be asked again, or 0.

    """

    status: int
    retry_after: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """What came of a try.

    Attributes
    ----------
    state
        That of the callback from now on.
    error
        Why the try failed.
    pause
        Seconds until the next one, while it is pending.

    """

    state: CallbackState
    error: str | None = None
    pause: float = 0.0
