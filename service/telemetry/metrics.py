"""The metrics of one process, for Prometheus."""

from collections.abc import Mapping

import orjson
from prometheus_client import CollectorRegistry, Counter, Histogram, ProcessCollector
from prometheus_client.registry import Collector

from service.jobs.fit import Fit, FitStatus

# Bounds of histograms: seconds of a request or one of its phases, seconds of a fit or a wait, points, degrees.
_REQUEST = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
_FIT = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0)
_POINTS = (30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000, 300_000, 1_000_000, 10_000_000)
_DEGREES = (2, 4, 6, 8, 10, 12, 14, 16, 20, 30, 40)
# What stands in the place of a route or a stop reason where there is none. Labels come from a fixed set of words, never
# from a caller: each value is kept for ever.
NONE = "none"


class Metrics:
    """Counts requests and fits. What is measured at the moment of a look is in `service.telemetry.gauges`."""

    def __init__(self) -> None:
        """Start with nothing counted, in a registry of its own."""
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        self._requests = self._counter("http_requests", "Requests that were answered.", "method", "route", "status")
        self._seconds = self._histogram("http_request_seconds", "Time to the end of an answer.", _REQUEST, "route")
        self._phases = self._histogram(
            "http_phase_seconds", "Time of a phase of a request, as in Server-Timing.", _REQUEST, "phase"
        )
        self._waits = self._histogram("queue_wait_seconds", "From acceptance to the first start.", _FIT, "lane")
        self._fits = self._counter("fits", "Fits that ended in this process.", "dimension", "status", "stop_reason")
        self._parts = self._counter("parts", "Parts of split fits that ended in this process.", "status")
        self._fit_seconds = self._histogram("fit_seconds", "Time of a fit in its worker.", _FIT, "dimension")
        self._points = self._histogram("fit_points", "Points of fits that ended.", _POINTS, "dimension")
        self._degrees = self._histogram("fit_degree", "Degrees of successful fits.", _DEGREES, "dimension")

    def add(self, collector: Collector) -> None:
        """Let a collector measure at each look, too."""
        self.registry.register(collector)

    def answered(self, method: str, route: str, status: int, seconds: float, phases: Mapping[str, float]) -> None:
        """Count a request: its route as in the OpenAPI document, and seconds in all and of each phase."""
        self._requests.labels(method, route, str(status)).inc()
        self._seconds.labels(route).observe(seconds)
        for name, took in phases.items():
            self._phases.labels(name).observe(took)

    def started(self, fit: Fit) -> None:
        """Count how long a fit waited for its first start."""
        if fit.attempt == 1 and fit.started is not None:
            waited = max(0.0, (fit.started - fit.created).total_seconds())
            self._waits.labels(fit.lane).observe(waited)

    def ended(self, fit: Fit, status: FitStatus, result: bytes | None, seconds: float) -> None:
        """Count a fit that ended, or a part of one; a fit fails with the first of its parts that does."""
        dimension = f"{fit.input.dimension}d"
        if fit.whole is not None:
            self._parts.labels(status.value).inc()
            if status is FitStatus.FAILED:
                self._fits.labels(dimension, status.value, NONE).inc()
            return
        found = {} if result is None else orjson.loads(result)
        self._fits.labels(dimension, status.value, found.get("stop_reason") or NONE).inc()
        self._fit_seconds.labels(dimension).observe(seconds)
        self._points.labels(dimension).observe(fit.input.points)
        if found:
            self._degrees.labels(dimension).observe(found["polynomial"]["degree"])

    def _counter(self, name: str, text: str, *labels: str) -> Counter:
        return Counter(f"ipfit_{name}", text, labels, registry=self.registry)

    def _histogram(self, name: str, text: str, bounds: tuple[float, ...], *labels: str) -> Histogram:
        return Histogram(f"ipfit_{name}", text, labels, buckets=bounds, registry=self.registry)
