"""Meshes and points over HTTP: made once, sent again, in parts, compressed; and not made for who has gone."""

import gzip
import io
import socket
import threading
import time

import httpx
import pytest
import zstandard

from tests.service.bodies import ellipse, npy, sphere, torus
from tests.service.conftest import Start
from tests.service.running import Server, until
from tests.service.test_problems import problem

NO_ENCODING = {"Accept-Encoding": "identity"}


@pytest.fixture(scope="module")
def ball(shared: Server) -> str:
    return f"/v1/fits/{shared.fit(npy(sphere()), 'max_degree=2')['id']}"


def made(answer: httpx.Response) -> float:
    """Return the milliseconds that the answer says its mesh took."""
    return float(answer.headers["Server-Timing"].partition("mesh;dur=")[2].partition(",")[0])


def test_a_mesh_is_made_once_and_known_by_its_tag(shared: Server, ball: str) -> None:
    where = f"{ball}/mesh?format=ply&resolution=120"
    first, again = (shared.client.get(where, headers=NO_ENCODING) for _ in range(2))
    assert first.content == again.content
    assert made(again) < 0.5 * made(first)
    etag = first.headers["ETag"]
    assert again.headers["ETag"] == etag
    known = shared.client.get(where, headers={"If-None-Match": etag})
    assert (known.status_code, known.content) == (304, b"")
    other = shared.client.get(where.replace("120", "119"), headers={"If-None-Match": etag})
    assert other.status_code == 200
    same = f"/v1/fits/{shared.fit(npy(sphere()), 'max_degree=2')['id']}/mesh?format=ply&resolution=120"
    assert shared.client.get(same, headers=NO_ENCODING).headers["ETag"] == etag  # the same polynomial and points


@pytest.mark.parametrize("path", ["mesh?format=obj&resolution=40", "points?format=csv", "points"])
def test_files_are_compressed_for_who_can_read_it(shared: Server, ball: str, path: str) -> None:
    plain = shared.client.get(f"{ball}/{path}", headers=NO_ENCODING)
    assert "Content-Encoding" not in plain.headers
    tags = {plain.headers["ETag"]}
    for accept, used in (
        ("gzip", "gzip"),
        ("zstd", "zstd"),
        ("gzip;q=0.5, zstd", "zstd"),
        ("*;q=0.1, zstd;q=0", "gzip"),
    ):
        with shared.client.stream("GET", f"{ball}/{path}", headers={"Accept-Encoding": accept}) as answer:
            sent = b"".join(answer.iter_raw())
        assert answer.headers["Content-Encoding"] == used
        assert "Accept-Encoding" in answer.headers["Vary"]
        unpack = (
            gzip.decompress
            if used == "gzip"
            else lambda data: zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)).read()
        )
        assert unpack(sent) == plain.content
        tags.add(answer.headers["ETag"])
        known = shared.client.get(f"{ball}/{path}", headers={"If-None-Match": answer.headers["ETag"]})
        assert (known.status_code, known.headers["ETag"]) == (304, answer.headers["ETag"])
    assert len(tags) == 3


def test_a_small_file_is_not_compressed(shared: Server, ball: str) -> None:
    answer = shared.client.get(f"{ball}/mesh?format=glb&resolution=4", headers={"Accept-Encoding": "gzip"})
    assert len(answer.content) < 4096
    assert "Content-Encoding" not in answer.headers


def test_a_range_of_a_file(shared: Server, ball: str) -> None:
    where = f"{ball}/mesh?format=stl&resolution=30"
    whole = shared.client.get(where, headers=NO_ENCODING)
    size, etag = len(whole.content), whole.headers["ETag"]
    assert whole.headers["Accept-Ranges"] == "bytes"

    def get(asked: str, **more: str) -> httpx.Response:
        return shared.client.get(where, headers=NO_ENCODING | {"Range": asked, **more})

    for asked, first, last in (
        ("bytes=0-83", 0, 84),
        (f"bytes={size - 10}-", size - 10, size),
        ("bytes=-7", size - 7, size),
    ):
        part = get(asked)
        assert (part.status_code, part.content) == (206, whole.content[first:last])
        assert part.headers["Content-Range"] == f"bytes {first}-{last - 1}/{size}"
    head = shared.client.head(where, headers=NO_ENCODING | {"Range": "bytes=0-83"})
    assert (head.status_code, head.headers["Content-Length"]) == (200, str(size))
    assert get("bytes=10-19", **{"If-Range": etag}).content == whole.content[10:20]
    assert get("bytes=10-19", **{"If-Range": '"old"'}).content == whole.content
    for ignored in ("bytes=0-1,5-6", "bytes=9-3", "lines=1-2", "bytes=-", "bytes=a-b", "x"):
        answer = get(ignored)
        assert (answer.status_code, answer.content) == (200, whole.content)
    for outside in (f"bytes={size}-", "bytes=-0", f"bytes={'9' * 18}-"):
        problem(get(outside, **{"If-Range": etag}), 416, "range-not-satisfiable")
        answer = get(outside)
        problem(answer, 416, "range-not-satisfiable")
        assert answer.headers["Content-Range"] == f"bytes */{size}"


def test_a_file_that_would_be_too_large_is_refused_before_it_is_made(start: Start) -> None:
    server = start(WORKERS=1, MAX_MESH_BYTES=2 * 2**20)
    where = f"/v1/fits/{server.fit(npy(sphere()), 'max_degree=2')['id']}/mesh?format=obj"
    small = server.client.get(f"{where}&resolution=64", headers=NO_ENCODING)
    told = problem(server.client.get(f"{where}&resolution=256"), 413, "too-large")
    assert told["errors"][0]["parameter"] == "resolution"
    predicted = float(told["detail"].partition("about ")[2].partition(" MiB")[0]) * 2**20
    assert predicted == pytest.approx(len(small.content) * (256 / 64) ** 2, rel=0.3)


def test_many_meshes_at_once_are_refused_and_nobody_else_waits_for_them(start: Start) -> None:
    server = start(WORKERS=1, WAITING_REQUESTS=4)
    where = f"/v1/fits/{server.fit(npy(torus(3000)), 'max_degree=4')['id']}/mesh?format=ply"
    answers: list[httpx.Response] = []

    def ask(resolution: int) -> None:
        answers.append(httpx.get(f"{server.url}{where}&resolution={resolution}", timeout=60.0))

    threads = [threading.Thread(target=ask, args=(256 - i,)) for i in range(12)]
    for thread in threads:
        thread.start()
    until(lambda: any(answer.status_code == 503 for answer in answers))
    upload = server.client.post(
        "/v1/fits?max_degree=2&geometric=false",
        content=npy(torus(20_000)),
        headers={"Content-Type": "application/x-npy"},
    )
    assert upload.json()["status"] == "successful"  # it did not wait for the meshes: some of them still do
    assert len(answers) < len(threads)
    for thread in threads:
        thread.join()
    refused = [answer for answer in answers if answer.status_code == 503]
    assert {answer.status_code for answer in answers} == {200, 503}
    for answer in refused:
        assert int(answer.headers["Retry-After"]) >= 1
        problem(answer, 503, "queue-full")


def test_the_work_for_a_client_that_has_gone_ends(start: Start) -> None:
    server = start(WORKERS=1)
    fit = server.fit(npy(torus(3000)), "max_degree=8&t1=0&measure_zero_set=false")
    url = httpx.URL(server.url)
    with socket.create_connection((url.host, url.port or 80)) as connection:
        path = f"/v1/fits/{fit['id']}/mesh?format=ply&resolution=256&extent=bounds"
        connection.sendall(f"GET {path} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        (worker,) = until(lambda: server.busy(0.1))
    until(lambda: worker not in server.workers(), 5.0)  # killed, long before it was ready
    assert server.client.get(f"/v1/fits/{fit['id']}/mesh?resolution=32").status_code == 200


def test_fits_whose_senders_have_gone_are_run_all_the_same(start: Start) -> None:
    server = start(WORKERS=1)
    url = httpx.URL(server.url)
    for i in range(30):
        body = npy(torus(1000 + i))
        head = (
            "POST /v1/fits?max_degree=1&geometric=false&measure_zero_set=false HTTP/1.1\r\nHost: x\r\n"
            f"Content-Type: application/x-npy\r\nContent-Length: {len(body)}\r\n\r\n"
        )
        with socket.create_connection((url.host, url.port or 80)) as connection:
            connection.sendall(head.encode() + body)
            time.sleep(0.002 * (i % 10))  # some go before the fit is stored, some while it is, and some after
    until(lambda: not live(server), 60.0)


def live(server: Server) -> list[str]:
    fits = server.client.get("/v1/fits?limit=100").json()["fits"]
    return [one["id"] for one in fits if one["status"] in ("accepted", "running")]


def test_the_cache_forgets_what_was_not_used_for_longest(start: Start) -> None:
    server = start(WORKERS=1, MESH_CACHE_BYTES=2**20)
    fit = f"/v1/fits/{server.fit(npy(sphere()), 'max_degree=2')['id']}"
    for resolution in range(20, 32, 2):
        assert server.client.get(f"{fit}/mesh?format=obj&resolution={resolution}", headers=NO_ENCODING).is_success
    kept = list((server.folder / "files").iterdir())
    assert 0 < sum(one.stat().st_size for one in kept) <= 2**20
    assert len(kept) < 6
    server.kill()
    again = start(WORKERS=1)
    assert not list((again.folder / "files").iterdir())


def test_a_removed_fit_is_not_found_though_its_mesh_is_in_the_cache(shared: Server) -> None:
    fit = f"/v1/fits/{shared.fit(npy(ellipse(46)))['id']}"
    etag = shared.client.get(f"{fit}/mesh").headers["ETag"]
    shared.client.delete(f"{fit}?purge=true")
    problem(shared.client.get(f"{fit}/mesh", headers={"If-None-Match": etag}), 404, "fit-not-found")
