"""The scenarios: what is asked for, by how many clients or at which rate."""

from collections.abc import Callable
from dataclasses import dataclass, field

from load.loops.traffic import Request, meshes, mixed, outlines, surfaces

# Given the URL of a server, return the requests that it gets.
Traffic = Callable[[str], list[Request]]


@dataclass(frozen=True)
class Scenario:
    """A scenario.

    Attributes
    ----------
    name
        In the table.
    traffic
        The requests.
    clients
        How many there are, in a closed loop: each waits for its answer.
    load
        In an open loop the rate of arrival, as a multiple of the rate that the closed loop of the same traffic reaches;
        0 in a closed loop.
    settings
        Settings of the server besides those of `load.engines`.
    beside
        Names of attackers (`load.attackers`) that are busy at the same time.
    workers
        How many processes do what is asked for.

    """

    name: str
    traffic: Traffic
    clients: int = 8
    load: float = 0.0
    settings: dict[str, object] = field(default_factory=dict)
    beside: tuple[str, ...] = ()
    workers: int = 2


def _outlines(_: str) -> list[Request]:
    return outlines(500)


def _surfaces_10_000(_: str) -> list[Request]:
    return surfaces(10_000)


def _surfaces_100_000(_: str) -> list[Request]:
    return surfaces(100_000)


def _mixed(_: str) -> list[Request]:
    return mixed()


SLOW = ("silent connections", "slow headers", "slow bodies", "GET /livez pipelined, never read")
CLOSED_MIXED = Scenario("mixed", _mixed)
SCENARIOS = (
    Scenario("outlines of 500 points", _outlines),
    Scenario("tori of 10,000 points", _surfaces_10_000),
    Scenario("tori of 100,000 points", _surfaces_100_000),
    CLOSED_MIXED,
    Scenario("meshes", meshes, workers=1),
    Scenario("outlines beside slow and hostile clients", _outlines, beside=SLOW),
    Scenario("outlines at 0.7 of capacity", _outlines, load=0.7),
    Scenario("mixed at 0.7 of capacity", _mixed, load=0.7),
    # A queue that fills within seconds, so that the run measures a full one.
    Scenario("outlines at twice capacity", _outlines, load=2.0, settings={"QUEUE_LIMIT": 100}),
)
SOAK = Scenario("soak", _mixed, load=0.5)
