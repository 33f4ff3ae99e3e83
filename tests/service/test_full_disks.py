"""Full disks and read-only databases: requests get 503, no fit is accepted, and fits go on when there is room."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import httpx
import pytest
from psycopg.conninfo import conninfo_to_dict

from tests.service.bodies import LONG, SOME_SECONDS, ellipse, npy, torus
from tests.service.clusters import Cluster
from tests.service.disks import Disk, small
from tests.service.postgres import Postgres
from tests.service.running import Server, until

NPY = {"Content-Type": "application/x-npy"}
# One that is read where it arrives, one that is spooled to disk, and one that is parsed in a worker.
BODIES = [npy(ellipse(61)), npy(torus(6000)), b'{"points": [' + b"[1.0, 2.0], [2.0, 1.0]," * 30_000 + b"[0.0, 0.0]]}"]
KINDS = ["application/x-npy", "application/x-npy", "application/json"]


def refuses(server: Server) -> None:
    """Check that whatever is sent is refused for now."""
    for content, kind in zip(BODIES, KINDS, strict=True):
        answer = server.client.post("/v1/fits", content=content, headers={"Content-Type": kind})
        assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready"), answer.text
        assert "Retry-After" in answer.headers
    assert server.client.get("/livez").is_success


def accepts(server: Server) -> bool:
    return server.client.post("/v1/fits", content=npy(ellipse(62)), headers=NPY).is_success


@pytest.fixture
def disk() -> Iterator[Disk]:
    with small(16) as made:
        yield made


def test_a_server_whose_disk_is_full_accepts_nothing_and_goes_on_when_there_is_room(
    disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(disk.folder))  # where its processes keep their notes, too
    server = Server(disk.folder, WORKERS=1)
    try:
        running = server.fit(LONG, SOME_SECONDS, "respond-async")
        waiting = [server.fit(LONG, f"t1=0&max_degree={degree}", "respond-async") for degree in (3, 4)]
        server.under_way(running)
        disk.fill()
        refuses(server)
        assert server.look(running)["status"] in {"running", "successful"}
        orphans = server.workers()
        server.kill()  # and it may die meanwhile
        server = Server(disk.folder, WORKERS=1)
        refuses(server)
        assert not set(orphans) & set(server.workers())
        disk.clear()
        for fit in (running, *waiting):
            until(lambda fit=fit: server.look(fit, wait=60)["status"] == "successful", 150)  # type: ignore[misc] # mypy cannot infer it
        assert server.fit(npy(ellipse()))["status"] == "successful"
    finally:
        server.kill()
    with closing(sqlite3.connect(disk.folder / "fits.sqlite")) as database:
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert database.execute("SELECT count(*) FROM fits").fetchone() == (4,)
        inputs = {row[0] for row in database.execute("SELECT input FROM fits")}
    assert {path.name for path in (disk.folder / "blobs").rglob("*") if path.is_file()} == inputs


def test_a_cluster_whose_blobs_have_no_room_accepts_nothing(tmp_path: Path, disk: Disk, postgres: Postgres) -> None:
    cluster = Cluster(tmp_path, postgres, BLOBS_URL=f"file://{disk.folder}")
    try:
        server, _ = cluster.serve(), cluster.work()
        kept = server.fit(npy(ellipse()))
        disk.fill()
        refuses(server)
        assert server.fit(npy(ellipse()))["status"] == "successful"  # these points are stored
        disk.clear()
        assert until(lambda: accepts(server))
        assert server.look(kept)["status"] == "successful"
        assert cluster.count() == 3
    finally:
        cluster.end()


@pytest.fixture
def tight(postgres: Postgres, disk: Disk) -> Iterator[str]:
    """Make a database whose tables are on the small disk; its log is not, so PostgreSQL itself goes on."""
    place = disk.folder / "tables"
    place.mkdir()
    postgres.give(place)
    postgres.tell(f"CREATE TABLESPACE tight LOCATION '{place}'")
    url = postgres.database("TABLESPACE tight")
    yield url
    disk.clear()
    postgres.tell(f"DROP DATABASE {name(url)} WITH (FORCE)")
    postgres.tell("DROP TABLESPACE tight")


def name(url: str) -> str:
    return str(conninfo_to_dict(url)["dbname"])


def test_a_database_without_room_is_503_and_loses_nothing(
    tmp_path: Path, disk: Disk, postgres: Postgres, tight: str
) -> None:
    cluster = Cluster(tmp_path, postgres, DATABASE_URL=tight)
    try:
        server, _ = cluster.serve(), cluster.work()
        fits = [server.fit(LONG, SOME_SECONDS, "respond-async")]
        server.under_way(fits[0])
        disk.fill()
        while (answer := sent(server, len(fits))).is_success:  # there is room in the last page of each table
            fits.append(answer.json())
        assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready"), answer.text
        refuses(server)
        disk.clear()
        assert [server.look(fit, wait=60)["status"] for fit in fits] == ["successful"] * len(fits)
        assert cluster.count() == len(fits)
        assert server.fit(npy(ellipse()))["status"] == "successful"
    finally:
        cluster.end()


def sent(server: Server, number: int) -> httpx.Response:
    headers = NPY | {"Prefer": "respond-async"}
    return server.client.post("/v1/fits", content=npy(ellipse(100 + number)), headers=headers)


def test_a_database_that_may_only_be_read_is_503_for_what_writes_and_loses_nothing(
    tmp_path: Path, postgres: Postgres
) -> None:
    database = postgres.database()
    cluster = Cluster(tmp_path, postgres, DATABASE_URL=database)
    try:
        server, _ = cluster.serve(), cluster.work()
        kept, running = server.fit(npy(ellipse())), server.fit(LONG, SOME_SECONDS, "respond-async")
        server.under_way(running)
        postgres.tell(f"ALTER DATABASE {name(database)} SET default_transaction_read_only = on")
        assert postgres.cut() > 2  # as after a failover to a standby that was not promoted
        refuses(server)
        answer = server.client.delete(f"/v1/fits/{running['id']}")
        assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready"), answer.text
        assert server.look(kept)["status"] == "successful"
        postgres.tell(f"ALTER DATABASE {name(database)} SET default_transaction_read_only = off")
        postgres.cut()
        assert server.look(running, wait=60)["status"] == "successful"
        assert until(lambda: accepts(server))
        assert cluster.count() == 3
    finally:
        cluster.end()
