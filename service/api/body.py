"""Take a request's body in without holding a large one in memory."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile

from fastapi import Request

from service.jobs.errors import NotReadyError, TooLargeError

# Up to this size a body is read and checked where it arrived, in a millisecond or two; a larger one goes through a file
# to a worker process.
INLINE = 256 * 1024


@asynccontextmanager
async def received(request: Request, most: int, folder: Path) -> AsyncIterator[bytes | Path]:
    """Yield the body: its bytes if small, else a file in `folder` that is removed afterwards.

    Raises
    ------
    TooLargeError
        As soon as it is known that more than `most` bytes come.
    NotReadyError
        If there is no room for a large one.

    """
    announced = request.headers.get("content-length", "")
    if announced.isdecimal() and int(announced) > most:
        raise _too_large(most)
    head, stream = bytearray(), request.stream()
    async for chunk in stream:
        head += chunk
        if len(head) > INLINE:
            break
    else:
        yield bytes(head)
        return
    with _room():
        file = NamedTemporaryFile(dir=folder, prefix="body-", delete=False)  # noqa: SIM115 - closed below
    path = Path(file.name)
    try:
        with _room(), file:
            size = file.write(head)
            async for chunk in stream:
                size += file.write(chunk)
                if size > most:
                    raise _too_large(most)
            if size > most:
                raise _too_large(most)
        yield path
    finally:
        path.unlink(missing_ok=True)  # noqa: ASYNC240 - a moment, as all of the above


@contextmanager
def _room() -> Iterator[None]:
    """Say that the disk is full, or whatever else the system has against a file, as something that may pass."""
    try:
        yield
    except OSError as error:
        raise NotReadyError(f"the body cannot be taken in at the moment: {error.strerror}") from error


def _too_large(most: int) -> TooLargeError:
    return TooLargeError(f"the body is larger than the {most} bytes that this server takes")
