"""The order in which fits run: fair between clients, with a lane in which short fits overtake long ones."""

from dataclasses import dataclass, field

from service.jobs.fit import Fit


@dataclass
class _Client:
    """The fits of one client that wait, and the time that its earlier ones got.

    Attributes
    ----------
    used
        Predicted seconds of its fits that were taken; the client that has used least is next.
    fits
        Its waiting fits by id, oldest first.

    """

    used: float
    fits: dict[str, Fit] = field(default_factory=dict)

    def first(self, *, short: bool) -> str | None:
        """Return the id of the oldest fit, or of the oldest short one."""
        return next((name for name, fit in self.fits.items() if fit.short or not short), None)


class FairQueue:
    """Waiting fits. Each client gets the same predicted time, as in fair queueing (Demers, Keshav, Shenker 1989)."""

    def __init__(self) -> None:
        """Start empty."""
        self._clients: dict[str, _Client] = {}
        # The virtual time: what a client would have used that had been waiting all the time. A new client starts here
        # and not at 0. It grows with every fit that is taken, so that no stream of new clients delays the others for
        # ever.
        self._now = 0.0
        self._short_running: dict[str, str] = {}  # the clients of short fits that run, by fit

    def add(self, fit: Fit) -> None:
        """Add a fit as the last of its client."""
        client = self._clients.setdefault(fit.client, _Client(self._now))
        client.fits[fit.id] = fit

    def remove(self, fit: Fit) -> None:
        """Remove a fit, if it is there."""
        client = self._clients.get(fit.client)
        if client is not None:
            client.fits.pop(fit.id, None)
            self._forget_idle()

    def take(self, *, short: bool = False) -> str | None:
        """Remove the next fit, or the next short fit, and return its id; None if there is none.

        The lane of short fits is for those whose other fits are long: a client of whom a short fit runs already gets no
        seat there, so that one who sends many of them leaves room for others.

        >>> from datetime import UTC, datetime
        >>> from service.jobs.fit import FitStatus, PointSetRef
        >>> from service.jobs.requested_options import RequestedOptions
        >>> queue, now = FairQueue(), datetime.now(UTC)
        >>> given, options = PointSetRef("", 3, 9), RequestedOptions({})
        >>> for name, client, cost in [("a1", "a", 60.0), ("a2", "a", 1.0), ("b1", "b", 60.0)]:
        ...     queue.add(Fit(name, FitStatus.ACCEPTED, given, options, now, client, cost))
        >>> queue.take(), queue.take(short=True), queue.take(), queue.take()
        ('a1', 'a2', 'b1', None)
        """
        every, served = self._clients, set(self._short_running.values()) if short else set()
        ready = [
            (client.used, found, name)
            for name, client in every.items()
            if name not in served and (found := client.first(short=short))
        ]
        if not ready:
            return None
        _, found, name = min(ready, key=lambda one: one[0])
        fit = every[name].fits[found]
        self._now += fit.cost / sum(bool(one.fits) for one in every.values())
        every[name].used += every[name].fits.pop(found).cost
        if fit.short:
            self._short_running[found] = name
        self._forget_idle()
        return found

    def ended(self, fit_id: str) -> None:
        """Note that a fit does not run any more, whether it has ended or will be added again."""
        self._short_running.pop(fit_id, None)

    def _forget_idle(self) -> None:
        """Forget clients without waiting fits that have used no more than a new client would start with."""
        idle = [name for name, client in self._clients.items() if not client.fits and client.used <= self._now]
        for name in idle:
            del self._clients[name]
