"""What a supervisor is told of a process: whether it is ready, and its metrics."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from prometheus_client.registry import Collector


class RequestObserver(Protocol):
    """Is told of every request that was answered."""

    def answered(self, method: str, route: str, status: int, seconds: float, phases: Mapping[str, float]) -> None:
        """Note a request: its route as in the OpenAPI document, and seconds in all and of each phase."""


class Exposition(Protocol):
    """Writes the metrics of the process."""

    def add(self, collector: Collector) -> None:
        """Let a collector measure at each look, too."""

    async def text(self, *, open_metrics: bool) -> bytes:
        """Return the metrics, measured at most a second ago; in the format OpenMetrics if wanted."""


@dataclass(frozen=True)
class Watch:
    """What a supervisor is told of a process.

    Attributes
    ----------
    check_ready
        Raises an error if the process is not ready for work.
    exposition
        Returns the metrics as text for Prometheus.
    requests
        Is told of every request.

    """

    check_ready: Callable[[], Awaitable[None]]
    exposition: Exposition
    requests: RequestObserver
