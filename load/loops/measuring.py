"""One scenario on one engine, measured."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import psutil
from scipy import stats

from load.engines import Engine, running
from load.loops import closed, open_loop
from load.loops.answers import Answers
from load.loops.scenarios import Scenario, Traffic
from load.loops.traffic import NPY, Request
from load.loops.watching import Seen, watching

WARMING = 8  # requests before a measurement, for each worker to have loaded all that it needs
STARTING = 15.0  # seconds longer that attackers are busy: a generator of load takes some to start
SLOPE_STEP = 4  # of all looks, those from which the slope of memory is worked out
IDLE = 0.2  # cores; with less, the machine is busy
BUSY = 0.85  # of the time; workers that are busy so much have always something to do
COLUMNS = [
    "scenario", "asked by", "answers/s", "p50", "p90", "p99", "most waiting", "429 / 503", "`/livez` p99", "memory",
    "cores kept busy", "what limits it",
]  # fmt: skip


@dataclass(frozen=True)
class Row:
    """What was measured of one scenario. `rate` is that of arrivals, 0 in a closed loop."""

    scenario: Scenario
    rate: float
    answers: Answers
    seen: Seen

    def __str__(self) -> str:
        """Return the row of the table."""
        asked = f"{self.rate:.1f}/s" if self.rate else f"{self.scenario.clients} clients"
        answers, seen = self.answers, self.seen
        cells = [self.scenario.name, asked, f"{answers.rate:.1f}"]
        cells += [f"{1000.0 * answers.percentile(percent):.0f} ms" for percent in (50, 90, 99)]
        cells += [f"{seen.most_waiting:.0f}", answers.refused(), f"{1000.0 * seen.livez_p99:.0f} ms"]
        cells += [f"{seen.memory_peak:.0f} MB", self._cores(), self._limit()]
        return f"| {' | '.join(cells)} |"

    def slope(self) -> str:
        """Return how memory grew in the second half, with the interval that has the slope with 95 % probability."""
        half = self.seen.looks[len(self.seen.looks) // 2 :: SLOPE_STEP]
        slopes = stats.theilslopes([one.memory for one in half], [one.at for one in half])
        slope, low, high = (3600.0 * one for one in (slopes.slope, slopes.low_slope, slopes.high_slope))
        return f"memory in the second half: {slope:+.1f} MB an hour ({low:+.1f} … {high:+.1f})"

    def _cores(self) -> str:
        return ", ".join(f"{name} {cores:.2f}" for name, cores in self.seen.cores.items() if name != "idle")

    def _limit(self) -> str:
        if self.seen.cores["idle"] < IDLE:
            return f"the processor: all {psutil.cpu_count()} cores are busy"
        if self.seen.cores["workers"] > BUSY * self.scenario.workers:
            return f"the processes that do this: {self.scenario.workers}"
        return "the rate of arrival" if self.rate else "each client waits for its answer"


def measure(engine: str, scenario: Scenario, seconds: float, capacity: float) -> Row:
    """Measure a scenario for so many seconds on an engine that is started for it.

    `capacity` is the rate of the closed loop with the same traffic; only an open loop needs it.
    """
    with (
        tempfile.TemporaryDirectory(prefix="ipfit-load-") as name,
        running(engine, Path(name), **scenario.settings) as started,
    ):
        folder, url = Path(name), f"http://127.0.0.1:{started.port}"
        requests = scenario.traffic(url)
        _warm(url, requests)
        rate = scenario.load * capacity
        with attacked(started, scenario, seconds), watching(started) as seen:
            if rate:
                answers = open_loop.run(url, requests, rate, seconds, folder)
            else:
                answers = closed.run(url, requests, scenario.clients, seconds, folder)
        return Row(scenario, rate, answers, seen.between(answers.began, answers.end))


def capacity_of(traffic: Traffic, rows: list[Row]) -> float:
    """Return the rate that the closed loop with this traffic reached, 0 if it was not measured."""
    found = [row.answers.rate for row in rows if row.scenario.traffic is traffic and not row.rate]
    return found[0] if found else 0.0


def _warm(url: str, requests: list[Request]) -> None:
    with httpx.Client(base_url=url, timeout=60.0) as client:
        for one in requests[:WARMING]:
            client.request(one.method, one.path, content=one.body, headers={"Content-Type": NPY}).raise_for_status()


@contextmanager
def attacked(engine: Engine, scenario: Scenario, seconds: float) -> Iterator[None]:
    """Let the attackers of a scenario be busy while the block runs."""
    commands = [
        [sys.executable, "-m", "load.attackers", name, str(engine.port), str(seconds + STARTING), ""]
        for name in scenario.beside
    ]
    attackers = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for command in commands]  # noqa: S603 - our own
    try:
        yield
    finally:
        for one in attackers:
            one.kill()
            one.wait()
