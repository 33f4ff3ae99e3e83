"""Who sends a request: whose fits these are, and how many they may be."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quota:
    """How much one caller may ask for.

    Attributes
    ----------
    waiting
        Fits that may wait for a worker at once; None means the share of the queue that every caller has.
    hourly
        Fits that may be accepted in an hour; None means any number.

    """

    waiting: int | None = None
    hourly: int | None = None


@dataclass(frozen=True)
class Caller:
    """The sender of a request.

    Attributes
    ----------
    client
        Between whom the queue is fair: the name of the API key, or the address if there are no keys.
    owner
        The name of the API key; empty if there are no keys. A fit belongs to the owner who sent it.
    quota
        How much the caller may ask for.

    """

    client: str = ""
    owner: str = ""
    quota: Quota = Quota()
