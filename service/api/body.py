"""Receiving the body of a request without holding a large one in memory."""

import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractContextManager, asynccontextmanager, contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile

from fastapi import Request

from service.api.transit import Transit
from service.jobs.errors import NotReadyError, TooLargeError
from service.jobs.media_types import JSON

# Bytes up to which a body stays in memory and is read in a thread, in a millisecond or two. A larger one is written to
# a file and read in a worker process. JSON takes longer, and all other requests wait meanwhile.
IN_MEMORY_BYTES, IN_MEMORY_BYTES_OF_JSON = 256 * 1024, 64 * 1024
SMALL_BYTES = 16 * 1024
LENGTH_DIGITS = 18  # of a length; Python refuses to read numbers of thousands of digits


def is_small(request: Request) -> bool:
    """Return whether the body is announced to be so small that it costs no more to read than to refuse."""
    announced = _announced(request)
    return announced is not None and announced <= SMALL_BYTES


def _announced(request: Request) -> int | None:
    """Return the length of the body that the head announces, if it does; one with too many digits is huge."""
    digits = request.headers.get("content-length", "")
    if not digits.isdecimal():
        return None
    digits = digits.lstrip("0") or "0"
    return int(digits) if len(digits) <= LENGTH_DIGITS else sys.maxsize


@asynccontextmanager
async def received(
    request: Request, kind: str, most: int, folder: Path, counted: AbstractContextManager[AsyncIterator[bytes]]
) -> AsyncIterator[bytes | Path]:
    """Yield the body, which is of the format `kind`, as bytes if it is small, else as a file in `folder`.

    The file is removed afterwards.

    `counted` yields its bytes, and counts them until then.

    Raises
    ------
    TooLargeError
        If it has more than `most` bytes; the rest is then not read.
    NotReadyError
        If a large one cannot be written to disk.
    QueueFullError
        If too many bytes of bodies are on their way in.

    """
    with counted as stream:
        small = IN_MEMORY_BYTES_OF_JSON if kind == JSON.name else IN_MEMORY_BYTES
        async with _received(request, stream, most, folder, small) as content:
            yield content


@contextmanager
def counted(request: Request, transit: Transit, client: str) -> Iterator[AsyncIterator[bytes]]:
    """Yield the stream of a body, whose bytes are counted as those of a client."""
    size = 0

    async def stream() -> AsyncIterator[bytes]:
        nonlocal size
        async for chunk in request.stream():
            transit.enter(len(chunk), client)
            size += len(chunk)
            yield chunk

    try:
        yield stream()
    finally:
        transit.leave(size, client)


@asynccontextmanager
async def _received(
    request: Request, stream: AsyncIterator[bytes], most: int, folder: Path, small: int
) -> AsyncIterator[bytes | Path]:
    if (_announced(request) or 0) > most:
        raise _too_large(most)
    head = bytearray()
    async for chunk in stream:
        head += chunk
        if len(head) > small:
            break
    else:
        yield bytes(head)
        return
    with _disk_errors():
        file = NamedTemporaryFile(dir=folder, prefix="body-", delete=False)  # noqa: SIM115 - closed below
    path = Path(file.name)
    try:
        with _disk_errors(), file:
            size = file.write(head)
            async for chunk in stream:
                size += file.write(chunk)
                if size > most:
                    raise _too_large(most)
            if size > most:
                raise _too_large(most)
        yield path
    finally:
        path.unlink(missing_ok=True)  # noqa: ASYNC240 - it takes microseconds, as do the writes above


@contextmanager
def _disk_errors() -> Iterator[None]:
    """Raise NotReadyError for an error of the file system, such as a full disk: it may pass."""
    try:
        yield
    except OSError as error:
        raise NotReadyError(f"the body cannot be taken in at the moment: {error.strerror}") from error


def _too_large(most: int) -> TooLargeError:
    return TooLargeError(f"the body is larger than the {most} bytes that this server takes")
