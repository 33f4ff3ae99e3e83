"""What came of a request for a fit."""

from dataclasses import dataclass

from service.jobs.admission import Allowance
from service.jobs.fit import Fit


@dataclass(frozen=True)
class Accepted:
    """A fit that was accepted now, or before.

    Attributes
    ----------
    fit
        It is stored, and survives a crash.
    allowances
        What its caller may still send.
    replayed
        Whether it was accepted before, for an earlier request with the same idempotency key.

    """

    fit: Fit
    allowances: list[Allowance]
    replayed: bool = False
