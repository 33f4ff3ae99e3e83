"""What a contender is, and what is known of one run of it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Trial:
    """A work that is ready to run: its input is in memory, and what it needs is imported.

    Attributes
    ----------
    warm
        The same work on a small input, for what a process does but once.
    run
        What is timed.
    judge
        What is found out of the outcome of `run` afterwards, ready for JSON.

    """

    warm: Callable[[], object]
    run: Callable[[], Any]
    judge: Callable[[Any], dict[str, Any]]


Contender = Callable[[Path], Trial]  # the folder holds the inputs


@dataclass(frozen=True)
class Report:
    """One run.

    Attributes
    ----------
    seconds, cpu
        Of the run, on the wall and of all threads.
    first
        Seconds of the small work before it, the first in its process.
    above
        Peak memory above what was resident before both, in MB.
    resident
        Peak memory in all, in MB.
    found
        What the judge found.
    failed
        Why there is nothing of all this; empty if there is.

    """

    seconds: float = float("nan")
    cpu: float = float("nan")
    first: float = float("nan")
    above: float = float("nan")
    resident: float = float("nan")
    found: dict[str, Any] = field(default_factory=dict)
    failed: str = ""
