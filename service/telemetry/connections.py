"""How many connections are open, and which requests were refused before they reached the application."""

from collections.abc import Callable, Iterator, Mapping

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector


class ConnectionCounts(Collector):
    """Collects the counts of a server's connections."""

    def __init__(self, opened: Callable[[], int], refused: Callable[[], Mapping[str, int]]) -> None:
        """Ask these functions: for the connections that are open, and for the refusals by the type of the problem."""
        self._opened, self._refused = opened, refused

    def collect(self) -> Iterator[Metric]:
        """Measure."""
        yield GaugeMetricFamily("ipfit_connections", "Connections that are open.", value=self._opened())
        refused = CounterMetricFamily(
            "ipfit_refused_requests", "Requests that were refused before they were read to their end.", labels=["code"]
        )
        for code, number in self._refused().items():
            refused.add_metric([code], number)
        yield refused
