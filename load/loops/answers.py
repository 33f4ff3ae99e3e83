"""The answers that a load generator got."""

import statistics
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from http import HTTPStatus


@dataclass(frozen=True)
class Answers:
    """Answers of one run.

    Attributes
    ----------
    counts
        How many there were of each status; 0 stands for a request without an answer.
    seconds
        How long each answer 200 took.
    rate
        The answers 200 in a second, while requests were sent.
    began, end
        When the first request was sent, and until when requests were to be sent, as `time.time` has it.

    """

    counts: Counter[int]
    seconds: list[float]
    rate: float
    began: float
    end: float

    @classmethod
    def of(cls, found: Iterable[tuple[float, int, float]], duration: float) -> "Answers":
        """Return what was found: when each answer came, its status, and the seconds that it took."""
        rows = list(found)
        good = [(at, took) for at, status, took in rows if status == HTTPStatus.OK]
        began = min((at - took for at, _, took in rows), default=0.0)
        end = began + duration
        rate = sum(at <= end for at, _ in good) / duration
        return cls(Counter(status for _, status, _ in rows), [took for _, took in good], rate, began, end)

    def percentile(self, percent: int) -> float:
        """Return the seconds that so many percent of the answers 200 took at most."""
        return percentile(self.seconds, percent)

    def refused(self) -> str:
        """Return how often the server said that it is too much: 429 and 503."""
        return f"{self.counts[HTTPStatus.TOO_MANY_REQUESTS]} / {self.counts[HTTPStatus.SERVICE_UNAVAILABLE]}"

    def unexpected(self) -> dict[int, int]:
        """Return the counts of the other answers; 202 is a fit that goes on."""
        allowed = (HTTPStatus.OK, HTTPStatus.ACCEPTED, HTTPStatus.TOO_MANY_REQUESTS, HTTPStatus.SERVICE_UNAVAILABLE)
        return {status: count for status, count in self.counts.items() if status not in allowed}


def percentile(values: list[float], percent: int) -> float:
    """Return the percentile; infinity if there are no values."""
    if len(values) < 2:  # noqa: PLR2004 - what statistics.quantiles needs
        return values[0] if values else float("inf")
    return statistics.quantiles(values, n=100, method="inclusive")[percent - 1]
