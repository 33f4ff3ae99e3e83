"""The types of a contender and of the report of one run."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Trial:
    """Work that is ready to be timed: its input is in memory and its libraries are imported.

    Attributes
    ----------
    warm
        Does the same work on a small input, so that one-time costs of the process are not timed.
    run
        The timed work.
    judge
        Measures the result of `run` afterwards; returns values that can be written as JSON.

    """

    warm: Callable[[], object]
    run: Callable[[], Any]
    judge: Callable[[Any], dict[str, Any]]


Contender = Callable[[Path], Trial]  # takes the folder with the inputs


@dataclass(frozen=True)
class Report:
    """The report of one run.

    Attributes
    ----------
    seconds, cpu
        Wall time and processor time of the run, all threads together.
    first
        Seconds of the warm-up work on the small input.
    above
        Peak memory above what was resident before the warm-up, in MB.
    resident
        Peak memory of the process, in MB.
    found
        What `judge` returned.
    failed
        The error, if the run failed; else empty.

    """

    seconds: float = float("nan")
    cpu: float = float("nan")
    first: float = float("nan")
    above: float = float("nan")
    resident: float = float("nan")
    found: dict[str, Any] = field(default_factory=dict)
    failed: str = ""
