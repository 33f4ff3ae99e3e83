"""Rounds in which the contenders run in turn, so that other work on the machine slows all of them alike."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Any

from contest.trial import Report

MAX_ROUNDS = 7


@dataclass(frozen=True)
class Medians:
    """The medians over some runs of one contender. `Report` says what each value is."""

    reports: Sequence[Report]

    @property
    def seconds(self) -> float:
        """Return the median wall time, in seconds."""
        return median(one.seconds for one in self.reports)

    @property
    def cpu(self) -> float:
        """Return the median processor time, in seconds."""
        return median(one.cpu for one in self.reports)

    @property
    def first(self) -> float:
        """Return the median time of the small warm-up work, in seconds."""
        return median(one.first for one in self.reports)

    @property
    def above(self) -> float:
        """Return the median of the peak memory above that before the work, in MB."""
        return median(one.above for one in self.reports)

    @property
    def resident(self) -> float:
        """Return the median of the peak memory of the whole process, in MB."""
        return median(one.resident for one in self.reports)

    @property
    def found(self) -> dict[str, Any]:
        """Return what the first run found; the other runs find the same."""
        return self.reports[0].found

    @property
    def failed(self) -> str:
        """Return the first error among the runs, or an empty string."""
        return next((one.failed for one in self.reports if one.failed), "")


Scores = Mapping[str, Medians]


def interleaved(names: Sequence[str], run: Callable[[str], Report], seconds: float) -> Scores:
    """Run all contenders in rounds, and return their medians by name.

    A round is started only if it will probably end within `seconds`, counted from the first round. A contender that has
    failed once is not run again.
    """
    reports: dict[str, list[Report]] = {name: [] for name in names}
    started = perf_counter()
    for done in range(MAX_ROUNDS):
        spent = perf_counter() - started
        if done and spent * (done + 1) / done > seconds:
            break
        for name in names:
            if not any(one.failed for one in reports[name]):
                reports[name].append(run(name))
    return {name: Medians(found) for name, found in reports.items()}


def seconds_of(scores: Scores, name: str) -> float:
    """Return the median wall time of a contender, or NaN if it failed or did not run."""
    return scores[name].seconds if name in scores and not scores[name].failed else math.nan


def rounds_as_text(scores: Scores) -> str:
    """Return the number of rounds as text for the page."""
    runs = max(len(one.reports) for one in scores.values())
    return "One round" if runs == 1 else f"Medians of {runs} interleaved rounds"
