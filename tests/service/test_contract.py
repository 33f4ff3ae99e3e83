"""The contract to the letter: methods, entity tags, ids of requests, parameters, keys, and what browsers may do."""

import re

import httpx
import pytest

from service.problem_types import PROBLEM_TYPES
from tests.service.bodies import HALF_A_MINUTE, LONG, ellipse, npy
from tests.service.conftest import Start
from tests.service.running import Server
from tests.service.test_problems import NPY, problem


@pytest.fixture(scope="module")
def fit(shared: Server) -> str:
    return f"/v1/fits/{shared.fit(npy(ellipse(41)))['id']}"


@pytest.mark.parametrize(
    ("path", "methods"),
    [
        ("/v1/fits", "GET, HEAD, OPTIONS, POST"),
        ("/v1/fits/any", "DELETE, GET, HEAD, OPTIONS"),
        ("/v1/fits/any/mesh?format=glb", "GET, HEAD, OPTIONS"),
        ("/livez", "GET, HEAD, OPTIONS"),
        ("/docs/assets/swagger-ui.css", "GET, HEAD, OPTIONS"),
    ],
)
def test_options_tells_the_methods_of_a_path(client: httpx.Client, path: str, methods: str) -> None:
    answer = client.options(path)
    assert (answer.status_code, answer.content, answer.headers["Allow"]) == (204, b"", methods)


def test_options_of_an_unknown_path(client: httpx.Client) -> None:
    problem(client.options("/nowhere"), 404, "not-found")


def test_every_answer_names_its_request_and_trace(client: httpx.Client, shared: Server) -> None:
    trace, mine = "4bf92f3577b34da6a3ce929d0e0e4736", "order-66/1"
    sent = {"traceparent": f"00-{trace}-00f067aa0ba902b7-01", "X-Request-Id": mine}
    for path in ("/livez", "/v1/fits/none", "/nowhere", "/docs/assets/swagger-ui.css"):
        answer = client.get(path, headers=sent)
        assert answer.headers["X-Request-Id"] == mine
        assert re.fullmatch(rf"00-{trace}-(?!00f067aa0ba902b7)[0-9a-f]{{16}}-01", answer.headers["traceparent"])
    assert f"[request {mine}, trace {trace}]" in shared.log
    assert client.get("/nowhere", headers=sent).json()["request_id"] == mine


@pytest.mark.parametrize("sent", ["", "a b", "x" * 129, "a\tb", "[request x]"])
def test_an_id_that_could_deceive_a_reader_of_the_log_is_replaced(client: httpx.Client, sent: str) -> None:
    assert re.fullmatch("[0-9a-f]{32}", client.get("/livez", headers={"X-Request-Id": sent}).headers["X-Request-Id"])


@pytest.mark.parametrize(
    "sent",
    [
        f"00-{'0' * 32}-00f067aa0ba902b7-01",
        f"00-{'a' * 32}-{'0' * 16}-01",
        f"ff-{'a' * 32}-{'b' * 16}-01",
        f"00-{'a' * 32}-{'b' * 16}-01-more",
        f"00-{'A' * 32}-{'b' * 16}-01",
    ],
)
def test_a_trace_that_is_not_valid_is_not_taken_over(client: httpx.Client, sent: str) -> None:
    answer = client.get("/livez", headers={"traceparent": sent}).headers["traceparent"]
    assert sent[3:35].lower() not in answer
    assert answer.endswith("-00")


def test_the_answer_says_where_its_time_went(shared: Server) -> None:
    answer = shared.client.post("/v1/fits", content=npy(ellipse(42)), headers=NPY)
    took = dict(re.findall(r"(\w+);dur=([0-9.]+)", answer.headers["Server-Timing"]))
    assert list(took) == ["read", "store", "wait", "total"]
    assert sum(float(took[name]) for name in ("read", "store", "wait")) <= float(took["total"]) + 1.0


def test_nothing_in_an_answer_is_run_by_a_browser(client: httpx.Client, fit: str) -> None:
    for path in (fit, f"{fit}/mesh", "/nowhere"):
        headers = client.get(path).headers
        assert headers["Content-Security-Policy"] == "default-src 'none'; frame-ancestors 'none'; sandbox"
        assert headers["X-Content-Type-Options"] == "nosniff"
    page = client.get("/docs").headers["Content-Security-Policy"]
    assert "default-src 'self'" in page
    assert "script-src 'self' 'sha256-" in page
    assert "access-control-allow-origin" not in client.get("/livez", headers={"Origin": "https://a.example"}).headers


def test_the_etag_is_compared_exactly(client: httpx.Client, fit: str) -> None:
    etag = client.get(fit).headers["ETag"]
    same = [etag, f"W/{etag}", f'"x", {etag}', "*"]
    other = [etag[:-2] + '"', f'"x{etag[1:]}', etag.strip('"'), f'"a {etag}', ""]
    told = [client.get(fit, headers={"If-None-Match": sent}).status_code for sent in same + other]
    assert told == [304] * len(same) + [200] * len(other)


def test_a_fit_is_removed_only_in_the_state_that_the_caller_saw(shared: Server) -> None:
    fit = f"/v1/fits/{shared.fit(npy(ellipse(43)))['id']}?purge=true"
    etag = shared.client.get(fit.partition("?")[0]).headers["ETag"]
    for sent in ('"other"', f"W/{etag}"):
        problem(shared.client.delete(fit, headers={"If-Match": sent}), 412, "precondition-failed")
    assert shared.client.delete(fit, headers={"If-Match": f'"other", {etag}'}).status_code == 204
    problem(shared.client.delete(fit, headers={"If-Match": "*"}), 404, "fit-not-found")


def test_what_is_dismissed_twice_is_still_there(shared: Server) -> None:
    live = shared.fit(LONG, HALF_A_MINUTE, prefer="respond-async")
    ended = shared.fit(npy(ellipse(44)))
    for one, status in ((live, "dismissed"), (ended, "successful")):
        where = f"/v1/fits/{one['id']}"
        for _ in range(3):
            answer = shared.client.delete(where)
            assert (answer.status_code, answer.json()["status"]) == (200, status)
        assert shared.client.get(where).json()["status"] == status
        assert shared.client.delete(f"{where}?purge=true").status_code == 204


def test_purging_ends_a_live_fit_first(shared: Server) -> None:
    live = shared.fit(LONG, HALF_A_MINUTE, prefer="respond-async")
    where = f"/v1/fits/{live['id']}"
    assert shared.client.delete(f"{where}?purge=true").status_code == 204
    problem(shared.client.get(where), 404, "fit-not-found")


@pytest.mark.parametrize(
    ("method", "path", "names"),
    [
        ("GET", "/livez?verbose=1", ["verbose"]),
        ("GET", "/v1/fits/any?wait=3", ["wait"]),
        ("DELETE", "/v1/fits/any?purge=true&purge=true", ["purge"]),
        ("GET", "/v1/fits/any/mesh?resolution=16&Resolution=32&bounds=1&bounds=2", ["Resolution", "bounds"]),
        ("POST", "/v1/fits?max_degre=3", ["max_degre"]),
        ("POST", "/v1/fits?t1=1&t1=2", ["t1"]),
        ("POST", "/v1/fits?max_degree=1_0", ["max_degree"]),
        ("POST", "/v1/fits?t1=%D9%A3", ["t1"]),
        ("GET", "/v1/fits?limit=1_0", ["limit"]),
        ("GET", "/problems?x", ["x"]),
        ("GET", "/docs?x=1", ["x"]),
    ],
)
def test_a_parameter_that_is_unknown_or_given_twice(
    client: httpx.Client, method: str, path: str, names: list[str]
) -> None:
    answer = client.request(method, path, headers=NPY if method == "POST" else {})
    assert [one["parameter"] for one in problem(answer, 422, "invalid-parameter")["errors"]] == names


@pytest.mark.parametrize("key", ["bare", '""', '"open', "'single'", '"é"', '"a";x', '"a", "b"', f'"{"k" * 201}"'])
def test_a_key_that_is_not_one_quoted_string(client: httpx.Client, key: str) -> None:
    sent = [(b"Content-Type", b"application/x-npy"), (b"Idempotency-Key", key.encode())]
    answer = client.post("/v1/fits", content=npy(ellipse()), headers=sent)
    (fault,) = problem(answer, 400, "malformed-header")["errors"]
    assert fault["parameter"] == "Idempotency-Key"


def test_two_keys_are_none(client: httpx.Client) -> None:
    sent = [("Content-Type", "application/x-npy"), ("Idempotency-Key", '"a"'), ("Idempotency-Key", '"b"')]
    problem(client.post("/v1/fits", content=npy(ellipse()), headers=sent), 400, "malformed-header")


@pytest.mark.parametrize("code", PROBLEM_TYPES)
def test_every_type_of_problem_has_a_page(client: httpx.Client, code: str) -> None:
    told = client.get(f"/problems/{code}").json()
    assert (told["type"], told["code"]) == (f"/problems/{code}", code)
    page = client.get(f"/problems/{code}", headers={"Accept": "text/html,*/*;q=0.8"})
    assert page.headers["Content-Type"].startswith("text/html")
    assert told["title"].replace("'", "&#x27;") in page.text
    assert told in client.get("/problems").json()["problems"]


def test_an_unknown_type_of_problem(client: httpx.Client) -> None:
    problem(client.get("/problems/none"), 404, "not-found")


def test_pages_of_origins_that_are_named_may_call(start: Start) -> None:
    server = start(CORS_ORIGINS="https://app.example, http://localhost:3000", WORKERS=1)
    asks = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "content-type,idempotency-key"}
    for origin, may in (
        ("https://app.example", True),
        ("http://localhost:3000", True),
        ("https://app.example.org", False),
    ):
        asked = server.client.options("/v1/fits", headers=asks | {"Origin": origin})
        assert (asked.headers.get("access-control-allow-origin") == origin) is may
        answer = server.client.get("/v1/fits/none", headers={"Origin": origin})
        assert (answer.headers.get("access-control-allow-origin") == origin) is may
        assert "ETag" in answer.headers["access-control-expose-headers"]
