"""Rounds in which all contenders take turns, so that whatever else the machine does meets all of them."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Any

from contest.trial import Report

MOST = 7  # rounds


@dataclass(frozen=True)
class Medians:
    """What some runs of one contender come to; see `Report` for what is what."""

    reports: Sequence[Report]

    @property
    def seconds(self) -> float:
        """Return the median of seconds on the wall."""
        return median(one.seconds for one in self.reports)

    @property
    def cpu(self) -> float:
        """Return the median of processor seconds."""
        return median(one.cpu for one in self.reports)

    @property
    def first(self) -> float:
        """Return the median of seconds of the small work before."""
        return median(one.first for one in self.reports)

    @property
    def above(self) -> float:
        """Return the median of peak memory above what was there before, in MB."""
        return median(one.above for one in self.reports)

    @property
    def resident(self) -> float:
        """Return the median of peak memory in all, in MB."""
        return median(one.resident for one in self.reports)

    @property
    def found(self) -> dict[str, Any]:
        """Return what was found in the first run; the others find the same."""
        return self.reports[0].found

    @property
    def failed(self) -> str:
        """Return why there is nothing of all this; one failure is enough."""
        return next((one.failed for one in self.reports if one.failed), "")


Scores = Mapping[str, Medians]


def interleaved(names: Sequence[str], run: Callable[[str], Report], seconds: float) -> Scores:
    """Run all, round after round, as long as the next round is likely to end within these seconds.

    What has failed once is not tried again.
    """
    reports: dict[str, list[Report]] = {name: [] for name in names}
    started = perf_counter()
    for done in range(MOST):
        spent = perf_counter() - started
        if done and spent * (done + 1) / done > seconds:
            break
        for name in names:
            if not any(one.failed for one in reports[name]):
                reports[name].append(run(name))
    return {name: Medians(found) for name, found in reports.items()}


def seconds_of(scores: Scores, name: str) -> float:
    """Return the time of a contender; not a number if it failed or did not run."""
    return scores[name].seconds if name in scores and not scores[name].failed else math.nan


def how_many(scores: Scores) -> str:
    """Return how many rounds there were, in words."""
    runs = max(len(one.reports) for one in scores.values())
    return "One round" if runs == 1 else f"Medians of {runs} interleaved rounds"
