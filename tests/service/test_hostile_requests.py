"""Requests that nobody means, over raw connections to one server: none is answered with an error of the server.

The requests are generated in tests/service/hostile, a module for each part of a request. After each family of them the
server must be alive and make a fit as before.
"""

from collections.abc import Callable, Iterator

import pytest

from tests.service.bodies import ellipse, npy, sphere
from tests.service.hostile import (
    framing,
    header_values,
    json_bodies,
    numpy_bodies,
    queries,
    request_lines,
    streams,
    tables,
    zero_sets,
)
from tests.service.hostile.cases import CURVE, SURFACE, Case
from tests.service.hostile.exchange import SECONDS, check_problem, exchange
from tests.service.running import Server

FAMILIES: tuple[Callable[[], list[Case]], ...] = (
    framing.smuggling, framing.chunks, framing.lines,
    request_lines.methods, request_lines.request_lines, request_lines.targets, request_lines.protocols,
    header_values.lines, header_values.values, header_values.posted,
    json_bodies.broken, json_bodies.wrong, json_bodies.packed, json_bodies.bombs,
    numpy_bodies.headers, numpy_bodies.files, tables.cells, tables.files, tables.readings,
    queries.option_values, queries.option_members, queries.queries,
    zero_sets.zero_sets, zero_sets.ids, streams.rows, streams.pieces, streams.cut_off,
)  # fmt: skip
GENERATED = {f"{made.__module__.rpartition('.')[2]}.{made.__name__}": made() for made in FAMILIES}
CASES = [(family, case) for family, cases in GENERATED.items() for case in cases]


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Start a server that does not wait long for what does not come; it must end without a traceback in its log."""
    server = Server(tmp_path_factory.mktemp("hostile") / "data", HEAD_TIMEOUT=1, STALL_TIMEOUT=1)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def fits(target: Server) -> dict[bytes, str]:
    """Return the ids of a curve and of a surface."""
    return {CURVE: target.fit(npy(ellipse()))["id"], SURFACE: target.fit(npy(sphere()))["id"]}


@pytest.mark.parametrize(("family", "case"), CASES, ids=[f"{family}: {case.name}" for family, case in CASES])
def test_no_request_is_answered_with_an_error_of_the_server(
    target: Server, fits: dict[bytes, str], family: str, case: Case
) -> None:
    talk = exchange(target, case.aimed(fits))
    assert talk.seconds < SECONDS
    assert talk.closed or len(talk.answers) <= case.answers, talk
    assert len(talk.answers) <= case.answers, talk
    assert talk.answers or (case.may_close and talk.closed), talk
    assert not talk.rest, talk
    for answer in talk.answers:
        assert answer.status in case.statuses, answer
        assert b"/smuggled" not in answer.body
        if answer.status >= 400 and not case.bodiless:
            check_problem(answer)
    if case is GENERATED[family][-1]:
        assert target.client.get("/livez").is_success
        assert target.fit(npy(ellipse()))["status"] == "successful"
        assert "Traceback" not in target.log, target.log[-5000:]


def test_there_are_enough_of_them() -> None:
    assert all(len({case.name for case in cases}) == len(cases) for cases in GENERATED.values())
    assert len(CASES) >= 2000
