"""The adapter that checks the URLs of callbacks and sends them."""

import asyncio
import logging
import os
import ssl
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from time import time

from service.callbacks.addresses import AllowedAddresses
from service.callbacks.exchange import exchange
from service.callbacks.resolving import LookUpRefusedError, resolved
from service.callbacks.signature import Signer
from service.callbacks.target import Target, is_address
from service.jobs.delivery import Answer, NotDeliveredError
from service.jobs.errors import InvalidInputError

logger = logging.getLogger(__name__)

TRY_SECONDS = 10.0  # from the look-up of the host to the head of the answer
OWN_HEADERS = {"User-Agent": f"ipfit/{version('ipfit')}", "Content-Type": "application/json", "Accept": "*/*"}


@dataclass(frozen=True)
class HttpSender:
    """Sends callbacks over HTTP, to addresses that are allowed. It follows no redirects and uses no proxies.

    Attributes
    ----------
    signer
        Signs every message.
    allowed
        The addresses.
    allow_http
        Whether to send without TLS, too.
    tls
        Which certificates are valid.
    resolve
        Looks up the addresses of a host.

    """

    signer: Signer
    allowed: AllowedAddresses
    allow_http: bool = False
    tls: ssl.SSLContext = field(default_factory=ssl.create_default_context)
    resolve: Callable[[str, int], Awaitable[list[str]]] = resolved

    def check(self, url: str) -> None:
        """Check the URL of a callback, without looking up its host.

        Raises
        ------
        InvalidInputError
            If nothing can or may be sent there.

        """
        try:
            target = Target.of(url, allow_http=self.allow_http)
        except ValueError as error:
            raise InvalidInputError(f"callback cannot be sent: {error}", ("callback",)) from None
        if is_address(target.host) and not self.allowed.has(target.host):
            raise InvalidInputError("callback may not be sent to an address that is not public", ("callback",))

    async def send(self, url: str, message_id: str, body: bytes) -> Answer:
        """Send one message, once, and return the answer, whatever its status.

        Raises
        ------
        NotDeliveredError
            If there is none, or the URL leads where nothing may be sent.

        """
        try:
            target = Target.of(url, allow_http=self.allow_http)  # what is allowed may have changed
        except ValueError as error:
            raise NotDeliveredError(f"callback cannot be sent: {error}") from None
        headers = OWN_HEADERS | self.signer.headers(message_id, int(time()), body)
        try:
            async with asyncio.timeout(TRY_SECONDS):
                return await exchange(target, await self._addresses(target), headers, body, self.tls)
        except TimeoutError:
            raise NotDeliveredError("the receiver did not answer in time") from None
        except OSError as error:
            raise NotDeliveredError(_words(error)) from None

    async def _addresses(self, target: Target) -> list[str]:
        """Return the addresses of the host, looked up once; all of them must be allowed.

        What the caller reads does not say whether a name exists that has no public address: it may be one of a private
        network.
        """
        try:
            found = [target.host] if is_address(target.host) else await self.resolve(target.host, target.port)
        except LookUpRefusedError as error:
            raise NotDeliveredError(str(error)) from None
        except OSError as error:
            found, why = [], str(error)
        else:
            why = f"it has the addresses {', '.join(found)}"
        if not found or not all(map(self.allowed.has, found)):
            logger.warning("no callback is sent to %s: %s", target.host, why)
            raise NotDeliveredError("the host has no address, or not only public ones")
        return found


def _words(error: OSError) -> str:
    """Return an error in words that name no address."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return f"the receiver's certificate is not valid: {error.verify_message}"
    if isinstance(error, ssl.SSLError):
        return f"no TLS connection: {error.reason or 'the handshake failed'}"
    if error.errno:
        return f"no connection: {os.strerror(error.errno)}"
    return "the connection was cut"
