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

from contest import memory, room
from contest.trial import Contender, Report, Trial

room.enter()  # before numpy is loaded, whose BLAS counts the cores


def measured(trial: Trial) -> Report:
    """Warm up, wait for the word, work, and judge."""
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
    """Return the report, or one that says why there is none."""
    try:
        return work()
    except Exception as error:  # noqa: BLE001 - whatever stops a contender belongs in its row
        words = str(error).splitlines() or [""]
        return Report(failed=f"{type(error).__name__}: {words[0]}".replace("|", "/"))  # it stands in a table


def main(module: str, name: str, folder: str) -> None:
    """Run it."""

    def work() -> Report:
        contender: Contender = import_module(f"contest.{module}").CONTENDERS[name]
        return measured(contender(Path(folder)))

    report = attempted(work)
    print(json.dumps(asdict(report)), flush=True)
    os._exit(0)  # a library's threads are no concern of the next contender


if __name__ == "__main__":
    main(*sys.argv[1:])
