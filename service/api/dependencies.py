"""The parts of the application that routes use, as a typed dependency."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from fastapi import Depends, Request

from service.api.limits import Limits
from service.api.transit import Transit
from service.api.watch import Watch
from service.api_keys import ApiKeys
from service.jobs.fit_files import FitFiles
from service.jobs.ports import Seats
from service.jobs.use_cases import FitService


@dataclass(frozen=True)
class Context:
    """The parts that routes use.

    Attributes
    ----------
    fits
        The use cases.
    files
        The use cases that make files of fits.
    limits
        The limits on a request.
    incoming
        Folder of large bodies while they are read.
    turns
        Lets clients take turns when their point sets are read and stored.
    transit
        Counts the bytes of bodies.
    watch
        What supervisors are told.
    keys
        The API keys; None if everybody may call.

    """

    fits: FitService
    files: FitFiles
    limits: Limits
    incoming: Path
    turns: Seats
    transit: Transit
    watch: Watch
    keys: ApiKeys | None = None


async def _context(request: Request) -> Context:
    context: Context = request.app.state.context
    return context


ContextDep = Annotated[Context, Depends(_context)]


async def _watch(request: Request) -> Watch:
    watch: Watch = request.app.state.watch
    return watch


WatchDep = Annotated[Watch, Depends(_watch)]
