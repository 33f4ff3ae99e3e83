"""Responses with files: whole or a range of their bytes, compressed or not."""

import re
from http import HTTPStatus

from fastapi import Request, Response
from fastapi.responses import FileResponse
from starlette.datastructures import MutableHeaders
from starlette.types import Receive, Scope, Send

from service.api import preconditions, problems
from service.jobs.exported_file import ExportedFile

_RANGE = re.compile(r"bytes=(\d{0,18})-(\d{0,18})")
# Files never change: another polynomial, request or version has another tag. Only their caller may store them.
KEEP = {"Cache-Control": "private, max-age=3600", "Vary": "Accept, Accept-Encoding, Authorization"}


class ReleasingFileResponse(FileResponse):
    """A response with a file, which is released when it has been sent, or cannot be sent any more."""

    def __init__(self, file: ExportedFile, headers: dict[str, str], media_type: str) -> None:
        """Send a file with these headers."""
        super().__init__(file.path, headers=headers, media_type=media_type, stat_result=file.path.stat())
        self._release = file.release

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the file."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._release()


def known_response(request: Request, name: str) -> Response | None:
    """Return a 304 if the caller has the file of this name, in any encoding; else None."""
    etag = preconditions.known(request, preconditions.strong_etag(name.encode()))
    if etag is None:
        return None
    return Response(status_code=HTTPStatus.NOT_MODIFIED, headers={"ETag": etag, **KEEP})


def file_response(
    request: Request, file: ExportedFile, name: str, media_type: str, headers: dict[str, str]
) -> Response:
    """Return a file, or the range of its bytes that the request asks for.

    Of several ranges none is taken, and the file is sent whole (RFC 9110, 14.2); so it is if Range cannot be read.
    """
    size = file.path.stat().st_size
    etag = preconditions.encoded_etag(preconditions.strong_etag(name.encode()), file.encoding)
    asked, unless = request.headers.get("range"), request.headers.get("if-range")
    own = {"ETag": etag, **KEEP, **headers}
    if file.encoding is not None:
        own["Content-Encoding"] = file.encoding
    if asked is not None and (request.method != "GET" or not _is_readable(asked) or unless not in {None, etag}):
        del MutableHeaders(scope=request.scope)["range"]
    elif asked is not None and not _is_inside(asked, size):
        file.release()
        unsatisfiable = {"Content-Range": f"bytes */{size}"}
        return problems.response(request, "range-not-satisfiable", f"the file has {size} bytes", headers=unsatisfiable)
    return ReleasingFileResponse(file, own, media_type)


def _is_readable(asked: str) -> bool:
    """Return whether a header asks for one range of bytes.

    >>> [_is_readable(one) for one in ("bytes=0-9", "bytes=-5", "bytes=9-0", "bytes=-", "lines=1-2", "bytes=0-1,3-4")]
    [True, True, False, False, False, False]
    """
    found = _RANGE.fullmatch(asked.strip())
    if found is None or not any(found.groups()):
        return False
    first, last = found.groups()
    return not (first and last) or int(first) <= int(last)


def _is_inside(asked: str, size: int) -> bool:
    """Return whether a range has at least one byte of a file."""
    first, _, last = asked.strip().removeprefix("bytes=").partition("-")
    return int(first) < size if first else int(last) > 0
