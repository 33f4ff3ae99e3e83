"""Who sends a request: by API key if the server has keys, else by address."""

from typing import Annotated

from fastapi import Depends, Request, Security
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer

from service.api.dependencies import ContextDep
from service.jobs.caller import Caller
from service.jobs.errors import UnauthorizedError

_BEARER = HTTPBearer(
    auto_error=False, scheme_name="ApiKey", description="An API key, if the operator of the server has given any."
)


async def caller_of(
    request: Request,
    context: ContextDep,
    credentials: Annotated[HTTPAuthorizationCredentials | None, Security(_BEARER)],
) -> Caller:
    """Return the sender of a request.

    Raises
    ------
    UnauthorizedError
        If the server has API keys, and the request none of them.

    """
    if context.keys is None:
        return Caller(client=request.client.host if request.client is not None else "")
    if credentials is None:
        raise UnauthorizedError("this server wants an API key: Authorization: Bearer ipfit_…")
    caller = context.keys.caller(credentials.credentials)
    if caller is None:
        raise UnauthorizedError("this API key is not known here")
    return caller


CallerDep = Annotated[Caller, Depends(caller_of)]
