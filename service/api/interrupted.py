"""Answering requests that are interrupted because the server stops."""

import asyncio

from fastapi import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api import problems


class Interrupted:
    """Answers 503 in the place of work that uvicorn cancels, when a stopping server has waited for it long enough."""

    def __init__(self, app: ASGIApp) -> None:
        """Wrap the application."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        begun = False

        async def noted(message: Message) -> None:
            nonlocal begun
            begun = True
            await send(message)

        try:
            await self._app(scope, receive, noted)
        except asyncio.CancelledError:
            if scope["type"] != "http" or begun:
                raise
            answer = problems.response(Request(scope), "shutting-down", "the server stopped before this was done")
            await answer(scope, receive, send)
