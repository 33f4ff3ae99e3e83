"""The Prefer header (RFC 7240): `wait=N` and `respond-async`."""

import re
from dataclasses import dataclass
from typing import Self

from fastapi import Request

DEFAULT_WAIT = 30.0


@dataclass(frozen=True)
class Preferences:
    """How long the caller will wait for an answer.

    Attributes
    ----------
    wait
        Seconds; None if the caller did not say.
    respond_async
        Whether the caller wants an answer at once.

    """

    wait: float | None = None
    respond_async: bool = False

    @classmethod
    def of(cls, request: Request) -> Self:
        """Read the request's preferences; unknown and malformed ones are ignored, as the RFC says."""
        sent = [part.strip().lower() for line in request.headers.getlist("prefer") for part in re.split("[,;]", line)]
        waits = [match.group(1) for part in sent if (match := re.fullmatch(r'wait\s*=\s*"?(\d{1,6})"?', part))]
        return cls(float(waits[0]) if waits else None, "respond-async" in sent)

    def seconds(self, default: float, longest: float) -> float:
        """Return how long to wait, at most `longest`: as asked for, 0 for a bare respond-async, else the default."""
        if self.wait is None:
            return 0.0 if self.respond_async else min(default, longest)
        return min(self.wait, longest)

    def applied(self, seconds: float) -> dict[str, str]:
        """Return the Preference-Applied header, if anything was asked for."""
        said = ["respond-async"] if self.respond_async else []
        said += [f"wait={seconds:.0f}"] if self.wait is not None else []
        return {"Preference-Applied": ", ".join(said)} if said else {}
