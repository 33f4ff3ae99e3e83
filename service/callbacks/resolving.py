"""Looking up the addresses of a host, once."""

import asyncio
import socket
from contextlib import suppress
from threading import Semaphore, Thread

# Look-ups at once, each in a thread. A try of a callback ends after ten seconds, but the look-up of a name whose
# servers are silent goes on for up to a minute: the four tries that a client may have at once occupy up to 24 threads.
# There is room for four such clients.
MOST_LOOK_UPS = 96
_free = Semaphore(MOST_LOOK_UPS)


class LookUpRefusedError(OSError):
    """Raised when this process cannot begin another look-up at the moment: nothing is known of the host."""


async def resolved(host: str, port: int) -> list[str]:
    """Return the addresses of a host, in the order in which they are to be tried.

    The look-up blocks for up to a minute and cannot be ended. So it has a thread of its own: it takes none from the
    store, which uses those of the event loop, and a server that stops does not wait for it.

    Raises
    ------
    OSError
        If there is no such host, or nobody answers for it.
    LookUpRefusedError
        If too many other look-ups are under way.

    """
    if not _free.acquire(blocking=False):
        raise LookUpRefusedError("too many other hosts were being looked up")
    loop = asyncio.get_running_loop()
    answer: asyncio.Future[list[str]] = loop.create_future()

    def settle(found: list[str] | OSError) -> None:
        if answer.done():  # nobody waits any longer
            return
        if isinstance(found, OSError):
            answer.set_exception(found)
        else:
            answer.set_result(found)

    def look_up() -> None:
        found: list[str] | OSError
        try:
            entries = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
            found = list(dict.fromkeys(str(entry[4][0]) for entry in entries))
        except OSError as error:
            found = error
        except UnicodeError as error:  # of a name that has no form in the DNS
            found = OSError(str(error))
        finally:
            _free.release()
        with suppress(RuntimeError):  # the loop has been closed
            loop.call_soon_threadsafe(settle, found)

    try:
        Thread(target=look_up, name=f"resolve {host}", daemon=True).start()
    except RuntimeError as error:
        _free.release()
        raise LookUpRefusedError("no thread could be started to look up the host") from error
    return await answer
