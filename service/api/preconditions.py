"""Entity tags, and the requests that depend on them (RFC 9110, 13)."""

import hashlib
import re
from http import HTTPStatus

from fastapi import Request
from starlette.exceptions import HTTPException

from service.compression import ENCODINGS

_TAG = r'(?:W/)?"[\x21\x23-\x7e\x80-\xff]*"'
_TAGS = re.compile(rf"\s*{_TAG}\s*(?:,\s*{_TAG}\s*)*")


def strong_etag(*parts: bytes) -> str:
    """Return the strong entity tag of a representation that is determined by these bytes, and not compressed."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(len(part).to_bytes(8, "little") + part)
    return f'"{digest.hexdigest()[:32]}"'


def encoded_etag(etag: str, encoding: str | None) -> str:
    """Return the tag of a representation in this encoding: its bytes are others, so its strong tag is.

    >>> encoded_etag('"a"', "gzip"), encoded_etag('"a"', None)
    ('"a-gzip"', '"a"')
    """
    return etag if encoding is None else f'{etag[:-1]}-{encoding}"'


def check_match(request: Request, etag: str) -> None:
    """Check the header If-Match, if there is one, by strong comparison.

    Raises
    ------
    HTTPException
        412 if the present state has none of its tags.

    """
    sent = request.headers.getlist("if-match")
    if sent and not _names(sent, etag, weak=False):
        raise HTTPException(HTTPStatus.PRECONDITION_FAILED, f"If-Match does not name the present state, {etag}")


def is_known(request: Request, etag: str) -> bool:
    """Return whether If-None-Match says that the caller has this state already, by weak comparison."""
    return _names(request.headers.getlist("if-none-match"), etag, weak=True)


def _names(lines: list[str], etag: str, *, weak: bool) -> bool:
    """Return whether a list of entity tags has this strong one, in any encoding, or is `*`. A malformed list has none.

    >>> _names(['W/"a", "b"'], '"a"', weak=True), _names(['W/"a", "b"'], '"a"', weak=False)
    (True, False)
    >>> _names(['"a-gzip"'], '"a"', weak=False), _names(['"a-lzma"'], '"a"', weak=False)
    (True, False)
    """
    text = ",".join(lines)
    if text.strip() == "*":
        return True
    tags = re.findall(_TAG, text) if _TAGS.fullmatch(text) else []
    same = {encoded_etag(etag, encoding) for encoding in (None, *ENCODINGS)}
    return not same.isdisjoint(tag.removeprefix("W/") if weak else tag for tag in tags)
