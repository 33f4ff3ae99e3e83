"""Who is next: fair between clients, with a lane in which short fits overtake long ones."""

from dataclasses import dataclass, field

from service.jobs.fit import Fit


@dataclass
class _Client:
    """What one client waits for, and what it has had.

    Attributes
    ----------
    used
        Predicted seconds of its fits that were taken; the client that has used least is next.
    fits
        Its waiting fits, oldest first.

    """

    used: float
    fits: dict[str, Fit] = field(default_factory=dict)

    def first(self, *, short: bool) -> str | None:
        """Return the oldest fit, or the oldest short one."""
        return next((name for name, fit in self.fits.items() if fit.short or not short), None)


class FairQueue:
    """Fits that wait. Every client gets the same predicted time, as in fair queueing (Demers, Keshav, Shenker 1989)."""

    def __init__(self) -> None:
        """Start with nobody in line."""
        self._clients: dict[str, _Client] = {}
        # What a client would have used that had waited all the time: one that comes anew starts here and not at 0.
        # It grows with every fit that is taken, so that no stream of new clients keeps the others waiting for good.
        self._now = 0.0

    def join(self, fit: Fit) -> None:
        """Put a fit at the end of its client's line."""
        client = self._clients.setdefault(fit.client, _Client(self._now))
        client.fits[fit.id] = fit

    def leave(self, fit: Fit) -> None:
        """Take a fit out, if it is in line."""
        client = self._clients.get(fit.client)
        if client is not None:
            client.fits.pop(fit.id, None)
            self._forget_idle()

    def take(self, *, short: bool = False) -> str | None:
        """Return the fit that is next, or the short fit that is, and take it out; None if there is none.

        >>> from datetime import UTC, datetime
        >>> from service.jobs.fit import FitStatus, PointSetRef
        >>> from service.jobs.requested_options import RequestedOptions
        >>> line, now = FairQueue(), datetime.now(UTC)
        >>> for name, client, cost in [("a1", "a", 60.0), ("a2", "a", 1.0), ("b1", "b", 60.0)]:
        ...     line.join(Fit(name, FitStatus.ACCEPTED, PointSetRef("", 3, 9), RequestedOptions({}), now, client, cost))
        >>> line.take(), line.take(short=True), line.take(), line.take()
        ('a1', 'a2', 'b1', None)
        """
        every = self._clients.values()
        ready = [(client.used, found, client) for client in every if (found := client.first(short=short))]
        if not ready:
            return None
        _, found, client = min(ready, key=lambda one: one[0])
        self._now += client.fits[found].cost / sum(bool(one.fits) for one in every)
        client.used += client.fits.pop(found).cost
        self._forget_idle()
        return found

    def _forget_idle(self) -> None:
        """Forget clients that wait for nothing and owe nothing to the others."""
        idle = [name for name, client in self._clients.items() if not client.fits and client.used <= self._now]
        for name in idle:
            del self._clients[name]
