"""Run contenders, each in a process of its own, one at a time or several at once."""

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Timer
from time import perf_counter

from contest import resources
from contest.trial import Report

BENCH = Path(__file__).resolve().parent.parent
TIME_LIMIT = 200.0  # seconds that a contender may take


@dataclass(frozen=True)
class ContenderRef:
    """A contender, by its module in this package and its name there, with the folder of its inputs and a Python."""

    module: str
    name: str
    folder: Path
    python: str = sys.executable


def run_alone(ref: ContenderRef) -> Report:
    """Run one contender and return its report."""
    return run_together([ref])[0]


def run_together(contenders: Sequence[ContenderRef]) -> list[Report]:
    """Run contenders at the same time and return their reports. The work starts when all of them are ready."""
    running = [_Running(one) for one in contenders]
    for one in running:
        one.wait_until_ready()
    for one in running:
        one.start()
    return [one.report() for one in running]


class _Running:
    """A child process that is killed after `TIME_LIMIT` seconds."""

    def __init__(self, ref: ContenderRef) -> None:
        command = [ref.python, "-m", "contest.child", ref.module, ref.name, str(ref.folder)]
        self._child = subprocess.Popen(  # noqa: S603 - ourselves
            command,
            env=resources.environment() | {"PYTHONPATH": str(BENCH)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # the report has the error; warnings by the thousand would hide it
            text=True,
        )
        self._started, self._last = perf_counter(), ""
        self._timer = Timer(TIME_LIMIT, self._child.kill)
        self._timer.start()

    def wait_until_ready(self) -> None:
        """Return when the child has read its input, or has ended."""
        for line in self._child.stdout or ():
            self._last = line.strip()
            if self._last == "ready" or self._last.startswith("{"):
                return

    def start(self) -> None:
        """Tell the child to start the timed work."""
        try:
            print(file=self._child.stdin, flush=True)
        except BrokenPipeError:
            return

    def report(self) -> Report:
        """Wait until the child has ended and return its report."""
        for line in self._child.stdout or ():
            self._last = line.strip() or self._last
        code = self._child.wait()
        self._timer.cancel()
        if code == 0 and self._last.startswith("{"):
            return Report(**json.loads(self._last))
        over = perf_counter() - self._started > TIME_LIMIT
        return Report(failed=f"not done in {TIME_LIMIT:.0f} s" if over else f"ended with {code}")
