"""What is measured at the moment at which somebody looks: queue, workers, memory."""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol

import psutil
from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from service.jobs.lane_load import LaneLoad

logger = logging.getLogger(__name__)

PATIENCE = 2.0  # seconds that the store may take


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

    def __init__(self, pools: Mapping[str, Pool], load: Callable[[], Iterable[LaneLoad]]) -> None:
        """Measure these pools, by their names; and the lanes of the queue, by a function that asks the store."""
        self._pools, self._load = pools, load
        self._thread = ThreadPoolExecutor(1, "queue-load")
        self._asked: Future[Iterable[LaneLoad]] | None = None

    def collect(self) -> Iterator[Metric]:
        """Measure; what cannot be measured at the moment is left out."""
        yield from self._workers()
        memory = GaugeMetricFamily(
            "ipfit_memory_bytes", "Memory; a page that n processes share counts 1/n in each.", labels=["process"]
        )
        for name, size in _memory().items():
            memory.add_metric([name], size)
        yield memory
        yield from self._queue()

    def _queue(self) -> Iterator[Metric]:
        """Ask the store about the queue; leave it out if that fails, as /readyz says, or takes too long."""
        if self._asked is None or self._asked.done():
            self._asked = self._thread.submit(self._load)
        try:
            yield from _lanes(self._asked.result(timeout=PATIENCE))
        except TimeoutError:
            logger.warning("the store did not say in %g s how much waits", PATIENCE)
        except Exception as error:  # noqa: BLE001 - of any database
            logger.warning("the store cannot say how much waits: %s", type(error).__name__)

    def _workers(self) -> Iterator[Metric]:
        workers = GaugeMetricFamily("ipfit_workers", "Worker processes.", labels=["pool", "state"])
        deaths = CounterMetricFamily("ipfit_worker_deaths", "Workers that died or were killed.", labels=["pool"])
        for name, pool in self._pools.items():
            workers.add_metric([name, "busy"], pool.busy)
            workers.add_metric([name, "idle"], pool.size - pool.busy)
            deaths.add_metric([name], pool.deaths)
        yield workers
        yield deaths


def _lanes(load: Iterable[LaneLoad]) -> Iterator[Metric]:
    fits = GaugeMetricFamily("ipfit_queue_fits", "Fits, and parts of fits, in the queue.", labels=["lane", "state"])
    oldest = GaugeMetricFamily("ipfit_queue_oldest_seconds", "Age of the oldest that waits.", labels=["lane"])
    for one in load:
        fits.add_metric([one.lane, "waiting"], one.waiting)
        fits.add_metric([one.lane, "running"], one.running)
        oldest.add_metric([one.lane], one.oldest)
    yield fits
    yield oldest


def _memory() -> dict[str, int]:
    """Return the bytes of this process, and of all that it started: its workers, and what starts them."""
    own = psutil.Process()
    return {"main": _size(own), "workers": sum(map(_size, own.children(recursive=True)))}


def _size(process: psutil.Process) -> int:
    """Return the bytes of a process, 0 if it has ended; of pages that it shares, its part, where the system tells."""
    try:
        return int(getattr(process.memory_full_info(), "pss", 0)) or int(process.memory_info().rss)
    except psutil.AccessDenied:
        return int(process.memory_info().rss)
    except psutil.NoSuchProcess:
        return 0
