"""The metrics as text, for any number of callers."""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.openmetrics import exposition as openmetrics
from prometheus_client.registry import Collector

# How old the text may be that a caller is given, in seconds: to measure the gauges takes tens of milliseconds.
_AGE = 1.0
_WRITERS: dict[bool, Callable[[CollectorRegistry], bytes]] = {
    False: generate_latest,
    True: openmetrics.generate_latest,
}


class Exposition:
    """Measures once for all who ask at the same time, in a thread of its own: others must not wait for the store."""

    def __init__(self, registry: CollectorRegistry) -> None:
        """Write the metrics of this registry."""
        self._registry = registry
        self._thread = ThreadPoolExecutor(1, "metrics")
        self._made: dict[bool, tuple[float, asyncio.Future[bytes]]] = {}

    def add(self, collector: Collector) -> None:
        """Let a collector measure at each look, too."""
        self._registry.register(collector)

    async def text(self, *, open_metrics: bool) -> bytes:
        """Return the metrics, measured at most a second ago; in the format OpenMetrics if wanted."""
        began, text = self._made.get(open_metrics, (0.0, None))
        if text is None or (text.done() and time.monotonic() - began >= _AGE):
            loop = asyncio.get_running_loop()
            text = loop.run_in_executor(self._thread, _WRITERS[open_metrics], self._registry)
            self._made[open_metrics] = time.monotonic(), text
        return await asyncio.shield(text)

    def close(self) -> None:
        """End the thread when it is done."""
        self._thread.shutdown(wait=False)
