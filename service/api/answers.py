"""What every answer carries: the ids of its request, how long the server took, and rules for browsers."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fastapi import Request
from opentelemetry import trace
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
# What is counted in the place of a route or a method that this server does not have. Callers may send anything, and
# each value would be counted apart, for ever.
UNKNOWN = "none"
# Its spans go nowhere, and cost nothing to speak of, unless an exporter is set up (`service.api.app`).
TRACER = trace.get_tracer("ipfit")
METHODS = {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"}


class Answers:
    """Adds these headers to every answer, those to unexpected errors included, and tells an observer of the answer."""

    def __init__(self, app: ASGIApp) -> None:
        """Wrap the application."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        began, span = time.perf_counter(), trace.get_current_span().get_span_context()
        ids = RequestIds.of(Headers(scope=scope).get).within(span)
        state: dict[str, Any] = scope.setdefault("state", {})
        state[_IDS], state[_PHASES] = ids, {}
        CURRENT.set(ids)
        status = 0

        async def send_with_headers(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = MutableHeaders(scope=message)
                headers.update(ids.headers)
                phases = state[_PHASES] | {"total": time.perf_counter() - began}
                headers["server-timing"] = ", ".join(f"{name};dur={1e3 * took:.1f}" for name, took in phases.items())
                for name, value in BROWSER_RULES.items():
                    headers.setdefault(name, value)
                if scope.get("scheme") == "https":
                    headers["strict-transport-security"] = HTTPS_ONLY
            await send(message)

        try:
            await self._app(scope, receive, send_with_headers)
        finally:
            if status:  # else nobody was there to be answered
                _tell(scope, status, time.perf_counter() - began)


def _tell(scope: Scope, status: int, seconds: float) -> None:
    """Tell the observer of this process, if it has one yet, of a request that was answered."""
    watch = getattr(scope["app"].state, "watch", None)
    if watch is not None:
        route = getattr(scope.get("route"), "path_format", UNKNOWN)
        method = scope["method"] if scope["method"] in METHODS else UNKNOWN
        watch.requests.answered(method, route, status, seconds, scope["state"][_PHASES])


def ids(request: Request) -> RequestIds:
    """Return the ids of a request."""
    found: RequestIds = getattr(request.state, _IDS)
    return found


@contextmanager
def phase(request: Request, name: str) -> Iterator[None]:
    """Measure a phase of the work for a request; the answer's Server-Timing lists it, and it is a span of its trace."""
    began = time.perf_counter()
    try:
        # a refusal is no error of the server, and its text is in the answer
        with TRACER.start_as_current_span(name, record_exception=False, set_status_on_exception=False):
            yield
    finally:
        getattr(request.state, _PHASES)[name] = time.perf_counter() - began
