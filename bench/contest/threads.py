"""The gain from threads, in one process and in two processes that share the machine."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter

from contest import clouds
from contest.clouds import Cloud
from contest.fitting import FEW, closeness, fitted
from contest.process import ContenderRef, run_together
from contest.resources import CORES
from contest.rounds import MAX_ROUNDS
from contest.trial import Contender, Report, Trial
from evidence.table import table

BASE, COUNT = 30_000, 300_000
CASES = [(processes, threads) for processes in (1, 2) for threads in (1, CORES)]


@dataclass(frozen=True)
class Case:
    """Runs of a number of processes at the same time, with a number of threads each."""

    processes: int
    threads: int
    runs: Sequence[Sequence[Report]]

    @property
    def failed(self) -> str:
        """Return the first error, or an empty string."""
        return next((one.failed for run in self.runs for one in run if one.failed), "")

    @property
    def seconds(self) -> float:
        """Return the seconds until all processes were done, median of the rounds."""
        return median(max(one.seconds for one in run) for run in self.runs)

    @property
    def cpu(self) -> float:
        """Return the processor time of one fit in seconds, median of all runs."""
        return median(one.cpu for run in self.runs for one in run)


def _ready(threads: int, folder: Path) -> Trial:
    cloud, given = Cloud.load(folder, "many"), {"threads": threads}
    few = cloud.first(FEW)
    return Trial(
        lambda: fitted(few, given=given),
        lambda: fitted(cloud, given=given),
        lambda found: closeness(found.polynomial, few),
    )


CONTENDERS: dict[str, Contender] = {str(threads): partial(_ready, threads) for threads in {1, CORES}}


def contest(folder: Path, seconds: float) -> list[Case]:
    """Run the cases in turn."""
    clouds.write_resampled(Cloud.of(clouds.named(clouds.names()[0], BASE)), COUNT, folder, "many")
    runs: dict[tuple[int, int], list[list[Report]]] = {case: [] for case in CASES}
    started = perf_counter()
    for done in range(MAX_ROUNDS):
        spent = perf_counter() - started
        if done and spent * (done + 1) / done > seconds:
            break
        for processes, threads in CASES:
            runs[processes, threads].append(run_together([ContenderRef("threads", str(threads), folder)] * processes))
    return [Case(*case, found) for case, found in runs.items()]


def shown(cases: Sequence[Case]) -> str:
    """Return the table."""
    lines = []
    for case in cases:
        cells = [case.failed, "", ""]
        if not case.failed:
            rate = case.processes / case.seconds
            cells = [f"{case.seconds:.3f}", f"{rate:.2f}", f"{case.cpu:.3f}"]
        lines.append([case.processes, case.threads, *cells])
    heads = ["processes at once", "threads each", "s until all are done", "fits per second", "CPU s per fit"]
    return f"{COUNT:,} points. {summary(cases)}\n\n{table(heads, lines)}"


def summary(cases: Sequence[Case]) -> str:
    """Return the table in two sentences."""
    if any(case.failed for case in cases):
        return "Not measured."
    one, two, shared, crowded = (case.seconds for case in cases)
    return (
        f"Medians of {len(cases[0].runs)} interleaved rounds. {CORES} threads are {one / two:.2f} times as fast as "
        f"one. Two processes with {CORES} threads each take {crowded / shared:.2f} times as long as with one each."
    )
