"""The format of the body of a request, and the format that the caller wants in the response."""

from collections.abc import Iterable
from email.message import Message
from functools import lru_cache
from http import HTTPStatus

from fastapi import Request
from starlette.exceptions import HTTPException

from service.compression import ENCODINGS
from service.jobs.media_types import (
    JSON,
    POINT_SET_FORMATS,
    ZERO_SET_FORMATS,
    PointSetFormat,
    ZeroSetFormat,
    zero_set_formats,
)

MOST_RANGES = 64  # of an Accept header that count: browsers send some ten


def point_set_format(request: Request, named: str | None) -> str:
    """Return the name of the body's format: `named` by ?format= if given, else that of Content-Type, else JSON.

    Raises
    ------
    HTTPException
        415 if no such format is read here, or if the body is encoded.

    """
    encoding = request.headers.get("content-encoding", "identity")
    if encoding != "identity":
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"Content-Encoding {encoding[:100]!r} is not read here")
    if named is not None:
        return named
    sent = media_type(request.headers.get("content-type", JSON.media_type))
    names = {known.media_type: known.name for known in POINT_SET_FORMATS}
    if sent not in names:
        known = ", ".join(names)
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"{sent[:100]} is not read here; known are {known}, or say ?format="
        )
    return names[sent]


def returned_point_set_format(request: Request, named: str | None) -> PointSetFormat:
    """Return the format in which the caller wants a point set: `named`, else the best for Accept, else npy.

    Raises
    ------
    HTTPException
        406 if Accept allows none.

    """
    if named is not None:
        return next(known for known in POINT_SET_FORMATS if known.name == named)
    accept = request.headers.get("accept", "*/*")
    as_stored_first = sorted(POINT_SET_FORMATS, key=lambda known: known.name != "npy")
    best = max(as_stored_first, key=lambda known: quality(accept, known.media_type))
    if quality(accept, best.media_type) <= 0.0:
        known = ", ".join(f"{one.name} ({one.media_type})" for one in POINT_SET_FORMATS)
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"Accept: {accept[:100]}: points come as {known}")
    return best


def content_encoding(request: Request) -> str | None:
    """Return the encoding in which the caller takes a file: the better liked of `zstd` and `gzip`; None for neither."""
    accept = request.headers.get("accept-encoding", "")
    best = max(ENCODINGS, key=lambda name: _encoding_quality(accept, name))
    return best if _encoding_quality(accept, best) > 0.0 else None


def _encoding_quality(accept: str, name: str) -> float:
    found = dict(reversed(_ranges(accept)))
    return found.get(name, found.get("*", 0.0))


def zero_set_format(request: Request, dimension: int, named: str | None = None) -> ZeroSetFormat:
    """Return the format in which the caller wants the zero set of a fit of this dimension.

    Raises
    ------
    HTTPException
        406 if there is no such format for this dimension.

    """
    made = zero_set_formats(dimension)
    accept = request.headers.get("accept", "*/*")
    chosen = _named(made, named) if named is not None else _best(accept, made)
    if chosen is None:
        asked = f"format={named}" if named is not None else f"Accept: {accept[:100]}"
        known = ", ".join(f"{kind.name} ({kind.media_types[0]})" for kind in made)
        raise HTTPException(HTTPStatus.NOT_ACCEPTABLE, f"{asked}: a {dimension}D zero set comes as {known}")
    return chosen


def wanted_file(request: Request, dimension: int) -> ZeroSetFormat | None:
    """Return the format in which the caller wants the zero set; None if JSON is wanted at least as much.

    Raises
    ------
    HTTPException
        406 if there is no such format for this dimension.

    """
    return zero_set_format(request, dimension) if wants_file(request) else None


def wants_file(request: Request) -> bool:
    """Return whether the Accept header prefers some format of zero sets to JSON."""
    accept = request.headers.get("accept", "*/*")
    offered = (name for known in ZERO_SET_FORMATS for name in known.media_types)
    return quality(accept, JSON.media_type) < max(quality(accept, name) for name in offered)


def _named(made: list[ZeroSetFormat], name: str) -> ZeroSetFormat | None:
    return next((kind for kind in made if kind.name == name), None)


def _best(accept: str, made: list[ZeroSetFormat]) -> ZeroSetFormat | None:
    """Return the format with the highest quality in the Accept header, the first of equals; None if all have 0."""
    ranked = [(max(quality(accept, name) for name in kind.media_types), kind) for kind in made]
    best = max(ranked, key=lambda row: row[0])
    return best[1] if best[0] > 0.0 else None


def media_type(header: str) -> str:
    """Return a Content-Type without its parameters, in lower case."""
    message = Message()
    message["content-type"] = header
    return message.get_content_type()


def quality(accept: str, name: str) -> float:
    """Return the quality that an Accept header gives to a media type, 0 … 1: that of the most specific range it is in.

    >>> quality("model/*;q=0.5, model/stl", "model/ply"), quality("text/html", "model/ply")
    (0.5, 0.0)
    """
    best = (-1, 0.0)
    for pattern, weight in _ranges(accept):
        fits = {"*/*": 0, name.split("/", maxsplit=1)[0] + "/*": 1, name: 2}.get(pattern)
        if fits is not None and fits > best[0]:
            best = (fits, weight)
    return best[1]


@lru_cache(maxsize=64)
def _ranges(accept: str) -> list[tuple[str, float]]:
    """Return the media ranges of an Accept header with their qualities, at most `MOST_RANGES`: the first ones."""
    parts = [
        [piece.strip() for piece in part.split(";")] for part in accept.lower().split(",", MOST_RANGES)[:MOST_RANGES]
    ]
    return [(pattern, _weight(parameters)) for pattern, *parameters in parts]


def _weight(parameters: Iterable[str]) -> float:
    for parameter in parameters:
        if parameter.startswith("q="):
            try:
                return min(max(float(parameter[2:]), 0.0), 1.0)
            except ValueError:
                return 0.0
    return 1.0
