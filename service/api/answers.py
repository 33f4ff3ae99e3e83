"""What every answer carries: the ids of its request, how long the server took, and rules for browsers."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fastapi import Request
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.request_ids import CURRENT, RequestIds

# Rules for browsers, in answers that have none of their own: nothing of an answer is run, framed or guessed at, and no
# other site may embed it. Answers are not stored where they do not say otherwise.
BROWSER_RULES = {
    "content-security-policy": "default-src 'none'; frame-ancestors 'none'; sandbox",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
# Once a browser has come by HTTPS, it stays with it for so long: a year.
HTTPS_ONLY = "max-age=31536000"
_IDS, _PHASES = "request_ids", "phases"


class Answers:
    """Adds these headers to every answer, those to unexpected errors included."""

    def __init__(self, app: ASGIApp) -> None:
        """Wrap the application."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        ids, began = RequestIds.of(Headers(scope=scope).get), time.perf_counter()
        state: dict[str, Any] = scope.setdefault("state", {})
        state[_IDS], state[_PHASES] = ids, {}
        CURRENT.set(ids)

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(ids.headers)
                phases = state[_PHASES] | {"total": time.perf_counter() - began}
                headers["server-timing"] = ", ".join(f"{name};dur={1e3 * took:.1f}" for name, took in phases.items())
                for name, value in BROWSER_RULES.items():
                    headers.setdefault(name, value)
                if scope.get("scheme") == "https":
                    headers["strict-transport-security"] = HTTPS_ONLY
            await send(message)

        await self._app(scope, receive, send_with_headers)


def ids(request: Request) -> RequestIds:
    """Return the ids of a request."""
    found: RequestIds = getattr(request.state, _IDS)
    return found


def phases(scope: Scope) -> dict[str, float]:
    """Return the seconds of each phase of a request that was measured."""
    found: dict[str, float] = scope.get("state", {}).get(_PHASES, {})
    return found


@contextmanager
def phase(request: Request, name: str) -> Iterator[None]:
    """Measure a phase of the work for a request; the answer's Server-Timing lists it."""
    began = time.perf_counter()
    try:
        yield
    finally:
        getattr(request.state, _PHASES)[name] = time.perf_counter() - began
