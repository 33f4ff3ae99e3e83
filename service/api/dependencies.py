"""What a route needs from its app, as a typed dependency."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from fastapi import Depends, Request

from service.api.limits import Limits
from service.jobs.use_cases import FitService


@dataclass(frozen=True)
class Context:
    """The parts behind the routes.

    Attributes
    ----------
    desk
        The use cases.
    limits
        What one request may ask for.
    incoming
        Folder for large bodies while they are read.

    """

    desk: FitService
    limits: Limits
    incoming: Path


def _context(request: Request) -> Context:
    context: Context = request.app.state.context
    return context


Here = Annotated[Context, Depends(_context)]
