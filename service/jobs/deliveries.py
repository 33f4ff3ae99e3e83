"""Delivering the callbacks of fits that have ended."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from http import HTTPStatus

from service.jobs.callback import MAX_TRIES, CallbackState, random_pause
from service.jobs.callback_ports import CallbackSender, CallbackStore
from service.jobs.delivery import Answer, Delivery, NotDeliveredError, Outcome

logger = logging.getLogger(__name__)

# Seconds between two looks for callbacks that are due.
DUE_CHECK_SECONDS = 1.0
# Seconds before the next look when the store failed.
STORE_PAUSE = 5.0
# Seconds after which a callback is tried again if the process that took it is not heard of. Twice as long as a try may
# take, so that nobody else takes one that is being sent.
LEASE_SECONDS = 20.0
# Callbacks that are sent at once: in all, to one host, so that a slow receiver leaves room for others, and of one
# client, who may have many receivers.
MOST_AT_ONCE, MOST_PER_HOST, MOST_PER_CLIENT = 16, 2, 4


@dataclass
class Deliveries:
    """Sends each callback until its receiver takes it: at least once, and more often if a process dies meanwhile.

    Attributes
    ----------
    store, sender
        Where callbacks are kept, and what sends them.
    path
        The path of all fits, as callers know it.
    pause
        Returns the seconds to the next try, after so many that failed; the second argument is what the receiver asked
        for.

    """

    store: CallbackStore
    sender: CallbackSender
    path: str
    pause: Callable[[int, float], float] = random_pause
    _hosts: Counter[str] = field(default_factory=Counter, init=False)  # tries that are under way, by host
    _clients: Counter[str] = field(default_factory=Counter, init=False)  # … and by client
    _freed: asyncio.Event = field(default_factory=asyncio.Event, init=False)

    async def keep_delivering(self) -> None:
        """Deliver what is due, again and again, until cancelled. What is being sent then is sent again later."""
        async with asyncio.TaskGroup() as tries:
            while True:
                self._freed.clear()
                await self._begin_due(tries)
                with suppress(TimeoutError):
                    async with asyncio.timeout(DUE_CHECK_SECONDS):
                        await self._freed.wait()

    async def _begin_due(self, tries: asyncio.TaskGroup) -> None:
        """Begin to send what is due, as far as there is room."""
        while self._hosts.total() < MOST_AT_ONCE and (delivery := await self._take()) is not None:
            self._hosts[delivery.host] += 1
            self._clients[delivery.client] += 1
            tries.create_task(self._deliver(delivery), name=f"callback of fit {delivery.fit_id}")

    async def _take(self) -> Delivery | None:
        hosts = [host for host, count in self._hosts.items() if count >= MOST_PER_HOST]
        clients = [client for client, count in self._clients.items() if count >= MOST_PER_CLIENT]
        try:
            return await asyncio.to_thread(self.store.take_due, hosts, clients, LEASE_SECONDS)
        except Exception as error:  # noqa: BLE001 - whatever a database raises
            logger.warning("callbacks cannot be looked up; the next try is in %g s: %s", STORE_PAUSE, error)
            await asyncio.sleep(STORE_PAUSE)
        return None

    async def _deliver(self, delivery: Delivery) -> None:
        """Make one try and record what came of it."""
        try:
            outcome = await self._outcome(delivery)
            await asyncio.to_thread(self.store.record, delivery, outcome)
        except Exception:  # it is due again when its lease has run out
            logger.exception("the callback of fit %s was tried, but what came of it is not stored", delivery.fit_id)
        finally:
            self._hosts -= Counter([delivery.host])  # forgets those that come to 0
            self._clients -= Counter([delivery.client])
            self._freed.set()

    async def _outcome(self, delivery: Delivery) -> Outcome:
        """Make one try and return what came of it."""
        if delivery.tries > MAX_TRIES:  # a process died in the last one
            return self._failed(delivery, delivery.last_error or "the last try was interrupted")
        answer = Answer(0)
        try:
            answer = await self.sender.send(delivery.url, delivery.message_id, delivery.body(self.path))
            why = f"the receiver answered {answer.status}"
        except NotDeliveredError as error:
            why = str(error)
        if 200 <= answer.status < 300:
            return Outcome(CallbackState.DELIVERED)
        if answer.status == HTTPStatus.GONE or delivery.tries == MAX_TRIES:
            return self._failed(delivery, why)
        asked = answer.retry_after if answer.status in (429, 503) else 0.0
        return Outcome(CallbackState.PENDING, why, self.pause(delivery.tries, asked))

    def _failed(self, delivery: Delivery, why: str) -> Outcome:
        logger.warning("the callback of fit %s to %s is given up: %s", delivery.fit_id, delivery.host, why)
        return Outcome(CallbackState.FAILED, why)
