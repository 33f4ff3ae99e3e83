"""Contenders run each in a process of its own, alone or several at once."""

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Timer
from time import perf_counter

from contest import room
from contest.trial import Report

BENCH = Path(__file__).resolve().parent.parent
LIMIT = 200.0  # seconds


@dataclass(frozen=True)
class Asked:
    """Which contender of which module, with the folder of its inputs, and the Python that runs it."""

    module: str
    name: str
    folder: Path
    python: str = sys.executable


def alone(asked: Asked) -> Report:
    """Run a contender by itself."""
    return together([asked])[0]


def together(asked: Sequence[Asked]) -> list[Report]:
    """Run contenders at once: all start working when all are ready."""
    running = [_Running(one) for one in asked]
    for one in running:
        one.wait_till_ready()
    for one in running:
        one.go()
    return [one.report() for one in running]


class _Running:
    """A child process, which ends at the limit at the latest."""

    def __init__(self, asked: Asked) -> None:
        command = [asked.python, "-m", "contest.child", asked.module, asked.name, str(asked.folder)]
        self._child = subprocess.Popen(  # noqa: S603 - ourselves
            command,
            env=room.surroundings() | {"PYTHONPATH": str(BENCH)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # what stops a contender is in its report; warnings by the thousand are not
            text=True,
        )
        self._started, self._last = perf_counter(), ""
        self._timer = Timer(LIMIT, self._child.kill)
        self._timer.start()

    def wait_till_ready(self) -> None:
        """Return when it has its input, or has ended."""
        for line in self._child.stdout or ():
            self._last = line.strip()
            if self._last == "ready" or self._last.startswith("{"):
                return

    def go(self) -> None:
        """Let it work."""
        try:
            print(file=self._child.stdin, flush=True)
        except BrokenPipeError:
            return

    def report(self) -> Report:
        """Return what it found, when it has ended."""
        for line in self._child.stdout or ():
            self._last = line.strip() or self._last
        code = self._child.wait()
        self._timer.cancel()
        if code == 0 and self._last.startswith("{"):
            return Report(**json.loads(self._last))
        over = perf_counter() - self._started > LIMIT
        return Report(failed=f"not done in {LIMIT:.0f} s" if over else f"ended with {code}")
