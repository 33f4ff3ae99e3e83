"""What is measured at the moment at which somebody looks: queue, workers, memory."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Protocol

import psutil
from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from service.jobs.lane_load import LaneLoad


class Pool(Protocol):
    """A pool of workers, as far as it is measured."""

    @property
    def size(self) -> int:
        """Return the number of workers."""

    @property
    def busy(self) -> int:
        """Return how many of them have a task."""

    @property
    def deaths(self) -> int:
        """Return how many worker processes died or were killed, and were replaced."""


class Gauges(Collector):
    """Collects the gauges of this process, and of its workers."""

    def __init__(self, pools: Mapping[str, Pool], load: Callable[[], Iterable[LaneLoad]] | None = None) -> None:
        """Measure these pools, by their names; and the lanes of the queue, by a function that asks the store."""
        self._pools, self._load = pools, load

    def collect(self) -> Iterator[Metric]:
        """Measure; what cannot be measured at the moment is left out."""
        yield from self._workers()
        memory = GaugeMetricFamily("ipfit_memory_bytes", "Memory, shared pages counted in parts.", labels=["process"])
        for name, size in _memory().items():
            memory.add_metric([name], size)
        yield memory
        if self._load is not None:
            with suppress(Exception):  # the store fails: /readyz says so
                yield from _queue(self._load())

    def _workers(self) -> Iterator[Metric]:
        workers = GaugeMetricFamily("ipfit_workers", "Worker processes.", labels=["pool", "state"])
        deaths = CounterMetricFamily("ipfit_worker_deaths", "Workers that died or were killed.", labels=["pool"])
        for name, pool in self._pools.items():
            workers.add_metric([name, "busy"], pool.busy)
            workers.add_metric([name, "idle"], pool.size - pool.busy)
            deaths.add_metric([name], pool.deaths)
        yield workers
        yield deaths


def _queue(load: Iterable[LaneLoad]) -> Iterator[Metric]:
    fits = GaugeMetricFamily("ipfit_queue_fits", "Fits, and parts of fits, in the queue.", labels=["lane", "state"])
    oldest = GaugeMetricFamily("ipfit_queue_oldest_seconds", "Age of the oldest that waits.", labels=["lane"])
    for one in load:
        fits.add_metric([one.lane, "waiting"], one.waiting)
        fits.add_metric([one.lane, "running"], one.running)
        oldest.add_metric([one.lane], one.oldest)
    yield fits
    yield oldest


def _memory() -> dict[str, int]:
    """Return the bytes of this process, and of all that it started."""
    own = psutil.Process()
    return {"main": _size(own), "workers": sum(map(_size, own.children(recursive=True)))}


def _size(process: psutil.Process) -> int:
    """Return the bytes of a process; of pages that it shares with others, its part, where the system knows it."""
    with suppress(psutil.Error):
        full = process.memory_full_info()
        return int(getattr(full, "pss", full.rss))
    return 0
