"""What a caller asked to be told when its fit has ended, and when the next try to tell it is due."""

import random
from dataclasses import dataclass
from enum import StrEnum
from urllib.parse import urlsplit


class CallbackState(StrEnum):
    """How far a callback is."""

    PENDING = "pending"
    DELIVERED = "delivered"
    FAILED = "failed"


# Tries after which a callback has failed: with the pauses below, after 22 hours.
MAX_TRIES = 10
# Seconds before the second try, and by what each later pause is longer than the one before.
FIRST_PAUSE, GROWTH = 5.0, 3.2
# The longest pause that a receiver can ask for (`Retry-After`), in seconds; our own may be longer.
LONGEST_ASKED = 3600.0


@dataclass(frozen=True)
class Callback:
    """The callback of a fit.

    Attributes
    ----------
    url
        Where to.
    state
        `pending` from the acceptance of the fit on.
    tries
        How often it was tried.
    last_error
        Why the last try failed.

    """

    url: str
    state: CallbackState = CallbackState.PENDING
    tries: int = 0
    last_error: str | None = None

    @property
    def host(self) -> str:
        """Return the host of the URL, in lower case."""
        return urlsplit(self.url).hostname or ""

    @property
    def shown_url(self) -> str:
        """Return the URL without its query, in which some receivers want a password.

        >>> Callback("https://hooks.example/fits?token=hunter2").shown_url
        'https://hooks.example/fits'
        """
        return self.url.partition("?")[0]


def pause(tries: int, asked: float, chance: float) -> float:
    """Return the seconds from a failed try to the next one.

    Parameters
    ----------
    tries
        How many have failed.
    asked
        What the receiver asked for, or 0.
    chance
        A random number from 0 to 1: it spreads the tries of many callbacks that failed together over half a pause.

    >>> [round(pause(tries, 0.0, 0.5)) for tries in range(1, MAX_TRIES)]
    [5, 16, 51, 164, 524, 1678, 5369, 17180, 54976]
    >>> pause(1, 60.0, 0.0), pause(1, 1e9, 0.0), pause(2, 0.0, 0.0), pause(2, 0.0, 1.0)
    (60.0, 3600.0, 12.0, 20.0)
    """
    own = FIRST_PAUSE * GROWTH ** (tries - 1)
    return max(own * (0.75 + 0.5 * chance), min(asked, LONGEST_ASKED))


def random_pause(tries: int, asked: float) -> float:
    """Return such a pause, with a chance of its own."""
    return pause(tries, asked, random.random())  # noqa: S311 - no secret
