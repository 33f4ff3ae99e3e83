"""The limits on a connection."""

import resource
from dataclasses import dataclass
from typing import Self

from service.jobs.bounds import HEAD_BYTES

# Descriptors that a server needs beside those of its connections: databases, worker pipes, files that are read.
OTHER_DESCRIPTORS = 128
MOST_CONNECTIONS = 10_000
# The share of all connections that one address may hold, so that one client cannot shut out all others.
SHARE_OF_AN_ADDRESS = 0.5


@dataclass(frozen=True)
class ConnectionLimits:
    """The limits on a connection, and on all together.

    Attributes
    ----------
    head_bytes, head_fields
        Bytes and header fields of a request's head (the request line and the headers).
    head_seconds
        From the start of a connection, or from the first byte of a later request, until the head is complete.
    stall_seconds
        How long a body may arrive, or a response be taken, at less than `least_rate`.
    least_rate
        Bytes per second.
    connections, connections_of_address
        How many may be open, in all and from one address.
    trusted
        Addresses of reverse proxies, to which `connections_of_address` does not apply; `*` trusts all.

    """

    head_bytes: int = HEAD_BYTES
    head_fields: int = 256
    head_seconds: float = 10.0
    stall_seconds: float = 30.0
    least_rate: float = 1024.0
    connections: int = 1000
    connections_of_address: int = 500
    trusted: frozenset[str] = frozenset()

    @classmethod
    def for_process(
        cls, *, head_seconds: float, stall_seconds: float, connections: int | None, trusted: frozenset[str]
    ) -> Self:
        """Return the limits of this process; by default, as many connections as its descriptors allow."""
        most = connections or min(MOST_CONNECTIONS, max(descriptors() - OTHER_DESCRIPTORS, 16))
        return cls(
            head_seconds=head_seconds,
            stall_seconds=stall_seconds,
            connections=most,
            connections_of_address=max(1, int(SHARE_OF_AN_ADDRESS * most)),
            trusted=trusted,
        )

    def is_trusted(self, address: str) -> bool:
        """Return whether an address is that of a reverse proxy."""
        return address in self.trusted or "*" in self.trusted


def descriptors() -> int:
    """Return how many files this process may open, after asking the system for enough for `MOST_CONNECTIONS`."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MOST_CONNECTIONS + OTHER_DESCRIPTORS
    most = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
    if soft != resource.RLIM_INFINITY and soft < most:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    return most
