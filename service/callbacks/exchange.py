"""One HTTP request to an address that was checked, and the head of its response."""

import asyncio
import ssl
from collections.abc import Mapping, Sequence
from contextlib import suppress
from email.utils import parsedate_to_datetime
from time import time

import h11

from service.callbacks.target import Target
from service.jobs.delivery import Answer, NotDeliveredError

CONNECT_SECONDS = 5.0  # with the handshake of TLS
REST_SECONDS = 1.0  # for the rest of a response, of which nothing is used
MOST_READ = 16 * 1024  # bytes of a response
READ_SIZE = 4096


async def exchange(
    target: Target, addresses: Sequence[str], headers: Mapping[str, str], body: bytes, tls: ssl.SSLContext
) -> Answer:
    """POST a body to a target, at the first of these addresses that can be connected to, and return the answer.

    Raises
    ------
    OSError
        If there is no connection, or the certificate is not valid.
    NotDeliveredError
        If what comes is no HTTP.

    """
    reader, writer = await _connected(target, addresses, tls)
    try:
        http = h11.Connection(h11.CLIENT)
        sent = {"Host": target.authority, **headers, "Content-Length": str(len(body)), "Connection": "close"}
        request = h11.Request(method="POST", target=target.path, headers=list(sent.items()))
        for event in (request, h11.Data(body), h11.EndOfMessage()):
            writer.write(http.send(event) or b"")
        return await _answer(reader, http)
    except h11.RemoteProtocolError:
        raise NotDeliveredError("the receiver closed the connection, or did not answer in HTTP") from None
    finally:
        writer.transport.abort()


async def _connected(
    target: Target, addresses: Sequence[str], tls: ssl.SSLContext
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Connect to the first address that can be reached: a machine may have no route for one of the two IP versions.

    The name in the certificate must be that of the host; only the connection goes to the address.
    """
    context, name = (tls, target.host) if target.scheme == "https" else (None, None)
    failure = OSError()
    for address in addresses:
        try:
            async with asyncio.timeout(CONNECT_SECONDS):
                return await asyncio.open_connection(address, target.port, ssl=context, server_hostname=name)
        except ssl.SSLError:
            raise
        except OSError as error:
            failure = error
    raise failure


async def _answer(reader: asyncio.StreamReader, http: h11.Connection) -> Answer:
    """Return the answer as soon as its head is there."""
    left = MOST_READ
    while not isinstance(event := http.next_event(), h11.Response):
        if event is h11.NEED_DATA:
            if left <= 0:
                raise NotDeliveredError(f"the head of the receiver's answer is longer than {MOST_READ} bytes")
            received = await reader.read(min(left, READ_SIZE))
            left -= len(received)
            http.receive_data(received)
    # Whoever writes the rest of a response in one more piece should not see its connection cut.
    with suppress(TimeoutError, OSError):
        async with asyncio.timeout(REST_SECONDS):
            while left > 0 and (received := await reader.read(min(left, READ_SIZE))):
                left -= len(received)
    return Answer(event.status_code, _retry_after(dict(event.headers).get(b"retry-after", b"")))


def _retry_after(value: bytes) -> float:
    """Return the seconds of a Retry-After header, which has a number of them or a date; 0 if it has neither.

    >>> _retry_after(b"120"), _retry_after(b"Wed, 21 Oct 2015 07:28:00 GMT"), _retry_after(b"soon")
    (120.0, 0.0, 0.0)
    """
    if value.isdigit():
        return float(value[:9])
    with suppress(ValueError, OverflowError):
        return max(parsedate_to_datetime(value.decode("latin-1")).timestamp() - time(), 0.0)
    return 0.0
