"""What a server uses while it is under load: processor time, memory, its queue, and how soon it answers `/livez`."""

import http.client
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from threading import Event, Thread

import psutil
from prometheus_client.parser import text_string_to_metric_families

from load.engines import Engine
from load.loops.answers import percentile

LIVEZ_EVERY, LOOK_EVERY = 0.02, 0.5  # seconds
MB = 2**20


@dataclass(frozen=True)
class Look:
    """What was seen of a server at one moment.

    Attributes
    ----------
    at
        When, as `time.time` has it.
    used
        Processor time so far, in seconds: of each program, of `workers` (all that the programs have started, but for
        those of PostgreSQL, which count there), and `idle`, that of the machine which nobody used.
    memory
        MB of the programs and all that they started, without PostgreSQL.
    waiting
        Fits that waited.

    """

    at: float
    used: dict[str, float]
    memory: float
    waiting: float


@dataclass
class Seen:
    """What was seen of a server: looks, and when each answer of `/livez` came, with the seconds that it took."""

    looks: list[Look] = field(default_factory=list)
    livez: list[tuple[float, float]] = field(default_factory=list)

    def between(self, began: float, end: float) -> "Seen":
        """Return what was seen in this time; at least two looks."""
        looks = [one for one in self.looks if began <= one.at <= end]
        if len(looks) < 2:  # noqa: PLR2004 - a difference needs two
            raise RuntimeError("the measurement was too short to look at the server twice")
        return Seen(looks, [one for one in self.livez if began <= one[0] <= end])

    @property
    def cores(self) -> dict[str, float]:
        """Return how many cores each part kept busy, and how many were idle."""
        first, last = self.looks[0], self.looks[-1]
        return {name: (used - first.used.get(name, 0.0)) / (last.at - first.at) for name, used in last.used.items()}

    @property
    def livez_p99(self) -> float:
        """Return the seconds that 99 of 100 answers of `/livez` took at most."""
        return percentile([took for _, took in self.livez], 99)

    @property
    def memory_peak(self) -> float:
        """Return the most memory, in MB."""
        return max(one.memory for one in self.looks)

    @property
    def most_waiting(self) -> float:
        """Return how many fits waited at most."""
        return max(one.waiting for one in self.looks)


@contextmanager
def watching(engine: Engine) -> Iterator[Seen]:
    """Watch a server until the block ends."""
    seen, enough = Seen(), Event()
    watchers = [Thread(target=watch, args=(engine, seen, enough), daemon=True) for watch in (_livez, _look)]
    for one in watchers:
        one.start()
    try:
        yield seen
    finally:
        enough.set()
        for one in watchers:
            one.join()


def _used(engine: Engine) -> dict[str, float]:
    """Return the processor time of each part so far, in seconds; that of processes that have ended counts, too."""
    used = dict.fromkeys([*engine.programs, "workers"], 0.0) | {"idle": psutil.cpu_times().idle}
    for name, pid in engine.programs.items():
        program = psutil.Process(pid)
        used[name] += _seconds(program)
        below = sum(map(_seconds, program.children(recursive=True)))
        used[name if name == "PostgreSQL" else "workers"] += below
    return used


def _seconds(process: psutil.Process) -> float:
    with suppress(psutil.NoSuchProcess):
        times = process.cpu_times()
        return times.user + times.system + times.children_user + times.children_system
    return 0.0


def _livez(engine: Engine, seen: Seen, enough: Event) -> None:
    """Ask `/livez` again and again, on one connection."""
    client = http.client.HTTPConnection("127.0.0.1", engine.port, timeout=30.0)
    while not enough.wait(LIVEZ_EVERY):
        began = time.perf_counter()
        client.request("GET", "/livez")
        client.getresponse().read()
        seen.livez.append((time.time(), time.perf_counter() - began))


def _look(engine: Engine, seen: Seen, enough: Event) -> None:
    """Look at memory and the queue again and again."""
    programs = [psutil.Process(pid) for name, pid in engine.programs.items() if name != "PostgreSQL"]
    while not enough.is_set():
        at, used, waiting = time.time(), _used(engine), _waiting(engine.port)
        size = sum(_size(one) for program in programs for one in [program, *program.children(recursive=True)])
        seen.looks.append(Look(at, used, size / MB, waiting))
        enough.wait(LOOK_EVERY)


def _size(process: psutil.Process) -> int:
    """Return the bytes of a process; a page that n processes share counts 1/n in each."""
    with suppress(psutil.NoSuchProcess, psutil.AccessDenied):
        return int(process.memory_full_info().pss)
    return 0


def _waiting(port: int) -> float:
    client = http.client.HTTPConnection("127.0.0.1", port, timeout=30.0)
    client.request("GET", "/metrics")
    text = client.getresponse().read().decode()
    client.close()
    return sum(
        sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
        if sample.name == "ipfit_queue_fits" and sample.labels["state"] == "waiting"
    )
