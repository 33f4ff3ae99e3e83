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
    if sent and not _named(sent, etag, weak=False):
        raise HTTPException(HTTPStatus.PRECONDITION_FAILED, f"If-Match does not name the present state, {etag}")


def known(request: Request, etag: str) -> str | None:
    """Return the tag by which If-None-Match says that the caller has this state already, by weak comparison."""
    found = _named(request.headers.getlist("if-none-match"), etag, weak=True)
    return found[0] if found else None


def _named(lines: list[str], etag: str, *, weak: bool) -> list[str]:
    """Return which tags of a list are this strong one, in any encoding; all, if it is `*`. A malformed list has none.

    >>> _named(['W/"a", "b"'], '"a"', weak=True), _named(['W/"a", "b"'], '"a"', weak=False)
    (['"a"'], [])
    >>> [_named([one], '"a"', weak=False) for one in ('"a-gzip"', '"a-lzma"', "*")]
    [['"a-gzip"'], [], ['"a"']]
    """
    text = ",".join(lines)
    if text.strip() == "*":
        return [etag]
    tags = re.findall(_TAG, text) if _TAGS.fullmatch(text) else []
    same = {encoded_etag(etag, encoding) for encoding in (None, *ENCODINGS)}
    return [bare for tag in tags if (bare := tag.removeprefix("W/") if weak else tag) in same]
