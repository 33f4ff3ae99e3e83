"""Which format came, and which one is wanted."""

from collections.abc import Iterable
from email.message import Message
from http import HTTPStatus

from fastapi import Request
from starlette.exceptions import HTTPException

from service.jobs.media_types import FILES, POINT_SETS, ZeroSetFormat

JSON = "application/json"


def point_set_kind(request: Request, named: str | None) -> str:
    """Return the kind of the body: what `?format=` says, else what Content-Type says, else JSON.

    Raises
    ------
    HTTPException
        415 if it is none that is read here, or if the body is encoded.

    """
    encoding = request.headers.get("content-encoding", "identity")
    if encoding != "identity":
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"Content-Encoding {encoding[:100]!r} is not read here")
    if named is not None:
        return named
    sent = media_type(request.headers.get("content-type", JSON))
    if sent not in POINT_SETS:
        known = ", ".join(POINT_SETS)
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"{sent[:100]} is not read here; known are {known}, or say ?format="
        )
    return POINT_SETS[sent]


def file_kind(request: Request, dimension: int, named: str | None = None) -> ZeroSetFormat:
    """Return the kind of zero-set file that is wanted from a fit of this dimension.

    Raises
    ------
    HTTPException
        406 if it is none that can be made.

    """
    made = [kind for kind in FILES if kind.dimension == dimension]
    accept = request.headers.get("accept", "*/*")
    chosen = _named(made, named) if named is not None else _best(accept, made)
    if chosen is None:
        asked = f"format={named}" if named is not None else f"Accept: {accept[:100]}"
        known = ", ".join(f"{kind.name} ({kind.media_types[0]})" for kind in made)
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"{asked}: a {dimension}D zero set comes as {known}")
    return chosen


def wants_file(request: Request) -> bool:
    """Return whether the caller of a fit wants a zero-set file rather than JSON."""
    accept = request.headers.get("accept", "*/*")
    return quality(accept, JSON) < max(quality(accept, name) for kind in FILES for name in kind.media_types)


def _named(made: list[ZeroSetFormat], name: str) -> ZeroSetFormat | None:
    return next((kind for kind in made if kind.name == name), None)


def _best(accept: str, made: list[ZeroSetFormat]) -> ZeroSetFormat | None:
    """Return the kind that the Accept header wants most, the earlier in the list the better."""
    ranked = [(max(quality(accept, name) for name in kind.media_types), kind) for kind in made]
    best = max(ranked, key=lambda row: row[0])
    return best[1] if best[0] > 0.0 else None


def media_type(header: str) -> str:
    """Return a Content-Type without its parameters, in lower case."""
    message = Message()
    message["content-type"] = header
    return message.get_content_type()


def quality(accept: str, name: str) -> float:
    """Return how much an Accept header wants a media type, 0 … 1: the most specific range that fits decides.

    >>> quality("model/*;q=0.5, model/stl", "model/ply"), quality("text/html", "model/ply")
    (0.5, 0.0)
    """
    best = (-1, 0.0)
    for part in accept.lower().split(","):
        pattern, *parameters = (piece.strip() for piece in part.split(";"))
        fits = {"*/*": 0, name.split("/", maxsplit=1)[0] + "/*": 1, name: 2}.get(pattern)
        if fits is not None and fits > best[0]:
            best = (fits, _weight(parameters))
    return best[1]


def _weight(parameters: Iterable[str]) -> float:
    for parameter in parameters:
        if parameter.startswith("q="):
            try:
                return min(max(float(parameter[2:]), 0.0), 1.0)
            except ValueError:
                return 0.0
    return 1.0
