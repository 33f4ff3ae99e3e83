"""Run one contender in this process: `python -m contest.child MODULE NAME FOLDER`.

It prints `ready` when its input is in memory, waits for a line, works, and prints a report as JSON on its last line.
"""

import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from time import perf_counter, process_time

from contest import memory, resources
from contest.trial import Contender, Report, Trial

resources.limit()  # before numpy is imported, whose BLAS counts the cores


def measured(trial: Trial) -> Report:
    """Run the warm-up, wait for a line on standard input, run the timed work, and return the report."""
    memory.forget()
    before = memory.peak()
    started = perf_counter()
    trial.warm()
    first = perf_counter() - started
    print("ready", flush=True)
    sys.stdin.readline()
    wall, cpu = perf_counter(), process_time()
    outcome = trial.run()
    wall, cpu = perf_counter() - wall, process_time() - cpu
    peak = memory.peak()
    return Report(wall, cpu, first, peak - before, peak, trial.judge(outcome))


def attempted(work: Callable[[], Report]) -> Report:
    """Return the report of the work, or one with the error if it raises."""
    try:
        return work()
    except Exception as error:  # noqa: BLE001 - whatever stops a contender belongs in its row
        lines = str(error).splitlines() or [""]
        return Report(failed=f"{type(error).__name__}: {lines[0]}".replace("|", "/"))  # | would end a cell of the table


def main(module: str, name: str, folder: str) -> None:
    """Run a contender and print its report."""

    def work() -> Report:
        contender: Contender = import_module(f"contest.{module}").CONTENDERS[name]
        return measured(contender(Path(folder)))

    report = attempted(work)
    print(json.dumps(asdict(report)), flush=True)
    os._exit(0)  # without waiting for threads that a library left running


if __name__ == "__main__":
    main(*sys.argv[1:])
