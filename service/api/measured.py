"""Telling an observer of every request that was answered."""

import time

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.answers import phases

# In the place of the route of a request that no route answers. A path could be anything, and each would be counted
# apart, for ever.
NO_ROUTE = "none"
METHODS = {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"}


class Measured:
    """Measures every request, from its head to the end of its answer."""

    def __init__(self, app: ASGIApp) -> None:
        """Wrap the application."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        status, began = 0, time.perf_counter()

        async def noted(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        try:
            await self._app(scope, receive, noted)
        finally:
            watch = getattr(scope["app"].state, "watch", None)
            if watch is not None and status:  # else nobody was there to be answered
                route = getattr(scope.get("route"), "path_format", NO_ROUTE)
                method = scope["method"] if scope["method"] in METHODS else NO_ROUTE
                watch.requests.answered(method, route, status, time.perf_counter() - began, phases(scope))
