"""The Prefer header (RFC 7240): `wait=N` and `respond-async`."""

import re
from dataclasses import dataclass
from typing import Self

from fastapi import Request

DEFAULT_WAIT = 30.0


@dataclass(frozen=True)
class Preferences:
    """How long the caller wants to wait for a fit to end.

    Attributes
    ----------
    wait
        Seconds; None if the caller gave none.
    respond_async
        Whether the caller asked for an answer at once.

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
        """Return the seconds to wait: `wait` if given, 0 for respond-async alone, else `default`; at most `longest`."""
        if self.wait is None:
            return 0.0 if self.respond_async else min(default, longest)
        return min(self.wait, longest)

    def applied(self, seconds: float) -> dict[str, str]:
        """Return the header Preference-Applied, or none if the caller gave no preference."""
        applied = ["respond-async"] if self.respond_async else []
        applied += [f"wait={seconds:.0f}"] if self.wait is not None else []
        return {"Preference-Applied": ", ".join(applied)} if applied else {}
