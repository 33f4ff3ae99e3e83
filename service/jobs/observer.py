"""The port of telemetry: who is told what becomes of fits."""

from typing import Protocol

from service.jobs.fit import Fit, FitStatus


class FitObserver(Protocol):
    """Is told what becomes of the fits, and of the parts of fits, that run in this process."""

    def started(self, fit: Fit) -> None:
        """Note that a fit has begun to run; `fit.attempt` says how often it has."""

    def ended(self, fit: Fit, status: FitStatus, result: bytes | None, seconds: float) -> None:
        """Note how a fit ended, with its result as JSON, and the seconds of the attempt in a worker."""


class _Unobserved:
    """Is told everything, and does nothing with it."""

    def started(self, fit: Fit) -> None:
        """Do nothing."""

    def ended(self, fit: Fit, status: FitStatus, result: bytes | None, seconds: float) -> None:
        """Do nothing."""


UNOBSERVED: FitObserver = _Unobserved()
