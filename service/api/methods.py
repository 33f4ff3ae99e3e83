"""HEAD and OPTIONS, for every path; and which methods a path answers to."""

from http import HTTPStatus
from typing import Any

from starlette.responses import Response
from starlette.routing import BaseRoute, Match, Mount
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_ASKED = ("GET", "POST", "PUT", "PATCH", "DELETE")


class HeadAndOptions:
    """Answers HEAD as GET without the body (RFC 9110, 9.3.2), and OPTIONS with the methods of the path."""

    def __init__(self, app: ASGIApp) -> None:
        """Wrap the application."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        method = scope["method"] if scope["type"] == "http" else ""
        if method == "HEAD":
            # Range is for GET only (RFC 9110, 14.2).
            headers = [(name, value) for name, value in scope["headers"] if name != b"range"]
            own = {**scope, "method": "GET", "headers": headers}
            try:
                await self._app(own, receive, _without_body(send))
            finally:
                scope["route"] = own.get("route")  # of which the metrics are told
        elif method == "OPTIONS" and (methods := _options(scope)):
            allow = {"Allow": ", ".join(sorted(methods))}
            await Response(status_code=HTTPStatus.NO_CONTENT, headers=allow)(scope, receive, send)
        else:
            await self._app(scope, receive, send)


def allowed(scope: Scope) -> set[str]:
    """Return all methods that a path answers to; the framework names only those of the first route that matches."""
    # As the application got it: routers have changed the scope before they find that the method is a wrong one.
    own = {**scope, "root_path": scope.get("app_root_path", scope.get("root_path", ""))}
    methods = {method for method in _ASKED if _answers(scope["app"].routes, own | {"method": method})}
    if "GET" in methods:
        methods.add("HEAD")
    return methods | {"OPTIONS"} if methods else methods


def _options(scope: Scope) -> set[str]:
    """Return the methods of the path, or of the whole server if the target is `*`."""
    return {*_ASKED, "HEAD", "OPTIONS"} - {"PUT", "PATCH"} if scope["path"] == "*" else allowed(scope)


def _without_body(send: Send) -> Send:
    async def send_without_body(message: Message) -> None:
        await send({**message, "body": b""} if message["type"] == "http.response.body" else message)

    return send_without_body


def _answers(routes: list[BaseRoute], scope: dict[str, Any]) -> bool:
    """Return whether a route takes this method at this path. Mounted files take GET only, besides HEAD."""
    matching = (route for route in routes if route.matches(scope)[0] is Match.FULL)
    return any(scope["method"] == "GET" or not isinstance(route, Mount) for route in matching)
