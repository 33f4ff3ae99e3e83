"""Targets: the value that is wanted, the value that was measured, and whether the target is met."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """One line of the table of targets: the goal, the measured value, and `met` or by how much it is missed."""

    goal: str
    measured: str
    verdict: str

    def cells(self) -> list[str]:
        """Return the cells of a table row."""
        return [self.goal, self.measured, self.verdict]


def at_most(what: str, value: float, limit: float, unit: str = "", note: str = "") -> Target:
    """Return the target of a value that must not exceed a limit.

    >>> at_most("peak", 250.0, 200.0, " MB").cells()
    ['peak: at most 200 MB', '250 MB', 'missed: 1.25 times as much']
    """
    verdict = "met" if value <= limit else f"missed: {value / limit:.2f} times as much"
    return Target(f"{what}: at most {limit:g}{unit}", *_cells(value, unit, note, verdict))


def at_least(what: str, value: float, limit: float, unit: str = "", note: str = "") -> Target:
    """Return the target of a value that must reach a limit."""
    verdict = "met" if value >= limit else f"missed: {value / limit:.2f} of it"
    return Target(f"{what}: at least {limit:g}{unit}", *_cells(value, unit, note, verdict))


def _cells(value: float, unit: str, note: str, verdict: str) -> tuple[str, str]:
    if math.isnan(value):
        return "not measured", "open"
    return f"{value:.3g}{unit}{note}", verdict
