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

LIVEZ_EVERY, LOOK_EVERY = 0.02, 1.0  # seconds
MB = 2**20


@dataclass
class Seen:
    """What was seen of a server in a run.

    Attributes
    ----------
    cores
        The cores that each part kept busy: `server` and so on the program's own process, `workers` what the programs
        have started, `PostgreSQL` all of its processes; `idle` those of the machine that nothing kept busy.
    memory
        Time in seconds, and MB of the programs and all that they started, without PostgreSQL, at each look.
    waiting
        Fits that waited, at each look.
    livez
        Seconds that each answer of `/livez` took.

    """

    cores: dict[str, float] = field(default_factory=dict)
    memory: list[tuple[float, float]] = field(default_factory=list)
    waiting: list[float] = field(default_factory=list)
    livez: list[float] = field(default_factory=list)

    @property
    def livez_p99(self) -> float:
        """Return the seconds that 99 of 100 answers of `/livez` took at most."""
        return percentile(self.livez, 99)

    @property
    def peak(self) -> float:
        """Return the most memory, in MB."""
        return max(size for _, size in self.memory)


@contextmanager
def watching(engine: Engine) -> Iterator[Seen]:
    """Watch a server until the block ends."""
    seen, enough = Seen(), Event()
    watchers = [Thread(target=watch, args=(engine, seen, enough), daemon=True) for watch in (_livez, _look)]
    began, before, idle = time.monotonic(), _used(engine), psutil.cpu_times().idle
    for one in watchers:
        one.start()
    try:
        yield seen
    finally:
        took = time.monotonic() - began
        after = _used(engine)
        enough.set()
        for one in watchers:
            one.join()
        seen.cores = {name: (used - before.get(name, 0.0)) / took for name, used in after.items()}
        seen.cores["idle"] = (psutil.cpu_times().idle - idle) / took


def _used(engine: Engine) -> dict[str, float]:
    """Return the processor time of each part so far, in seconds; that of processes that have ended counts, too."""
    used = dict.fromkeys([*engine.programs, "workers"], 0.0)
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
        seen.livez.append(time.perf_counter() - began)


def _look(engine: Engine, seen: Seen, enough: Event) -> None:
    """Look at memory and the queue again and again."""
    began = time.monotonic()
    programs = [psutil.Process(pid) for name, pid in engine.programs.items() if name != "PostgreSQL"]
    while not enough.is_set():
        size = sum(_size(one) for program in programs for one in [program, *program.children(recursive=True)])
        seen.memory.append((time.monotonic() - began, size / MB))
        seen.waiting.append(_waiting(engine.port))
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
