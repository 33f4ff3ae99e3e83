"""The processes that hold the leases of running fits."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LeaseHolder:
    """A process that runs fits on leases of the store, which it has to renew.

    Attributes
    ----------
    name
        A unique name of the process.
    lease
        Seconds after which a lease runs out that was not renewed.

    """

    name: str
    lease: float
