"""The ports of callbacks: what the domain needs to check, keep and send them."""

from collections.abc import Collection
from typing import Protocol

from service.jobs.delivery import Answer, Delivery, Outcome


class CallbackRules(Protocol):
    """Which callbacks are accepted."""

    def check(self, url: str) -> None:
        """Check the URL of a callback, without looking up its host.

        Raises
        ------
        InvalidInputError
            If nothing can or may be sent there.

        """


class CallbackStore(Protocol):
    """The callbacks of fits. They are stored, and become due, in the transactions that add and end the fits."""

    def take_due(self, hosts: Collection[str], clients: Collection[str], lease: float) -> Delivery | None:
        """Take the callback that has been due for longest, to none of these hosts and of none of these clients.

        Return None if there is none.

        It counts as tried. No other process takes it for `lease` seconds; then it is due again, unless the outcome was
        recorded.
        """

    def record(self, delivery: Delivery, outcome: Outcome) -> bool:
        """Store what came of a try, unless it was taken again meanwhile; return whether it was stored."""


class CallbackSender(Protocol):
    """Sends callbacks."""

    async def send(self, url: str, message_id: str, body: bytes) -> Answer:
        """Send one message, once, and return the answer, whatever its status.

        Raises
        ------
        NotDeliveredError
            If there is none, or the URL leads where nothing may be sent.

        """
