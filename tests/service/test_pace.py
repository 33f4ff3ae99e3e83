"""How slowly a body may arrive."""

from service.connections.limits import ConnectionLimits
from service.connections.pace import Pace

LIMITS = ConnectionLimits(stall_seconds=30.0, least_rate=1024.0)


def late_at(sent: dict[int, int], until: int = 3600, *, paused: range = range(0)) -> int | None:
    """Return the second at which a body is late of which so many bytes arrive at these seconds; None if never."""
    pace = Pace(LIMITS)
    pace.wait_for_body(0.0)
    for second in range(1, until):
        pace.received += sent.get(second, 0)
        if pace.body_is_late(float(second), paused=second in paused):
            return second
    return None


def test_who_sends_nothing_is_late_after_the_stall_time() -> None:
    assert late_at({}) == 31


def test_a_fast_beginning_buys_no_silence() -> None:
    assert late_at({1: 63_000_000}) == 62


def test_who_is_fast_enough_may_take_long() -> None:
    assert late_at(dict.fromkeys(range(1, 3600), 1100)) is None
    assert late_at(dict.fromkeys(range(1, 3600), 900)) == 31


def test_time_in_which_the_server_does_not_read_does_not_count() -> None:
    assert late_at({}, paused=range(1, 101)) == 131
