"""What a server takes of its machine, and what others on the machine may see of it."""

import os
import resource
import tempfile
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import pytest

from service.bootstrap import memory
from service.settings import Settings
from service.temporary_folders import FOLDER_PREFIX, TemporaryFolder, temporary_folder
from tests.service.bodies import ellipse, npy, torus
from tests.service.conftest import Start
from tests.service.running import Server, until
from tests.service.test_problems import JSON, NPY, problem


def modes(folder: Path) -> dict[str, str]:
    return {str(one.relative_to(folder)): oct(one.stat().st_mode & 0o777) for one in folder.rglob("*")}


def test_nobody_but_its_user_may_read_the_data_folder(shared: Server) -> None:
    shared.fit(npy(ellipse(47)))
    assert oct(shared.folder.stat().st_mode & 0o777) == "0o700"
    found = modes(shared.folder)
    assert {found[name] for name in found if (shared.folder / name).is_file()} == {"0o600"}
    assert {found[name] for name in found if (shared.folder / name).is_dir()} == {"0o700"}


def test_what_a_killed_server_left_is_removed_by_the_next_one(start: Start) -> None:
    def own(server: Server) -> set[Path]:
        held = {one.readlink() for one in Path(f"/proc/{server.process.pid}/fd").iterdir() if one.exists()}
        return {one.parent for one in held if one.parent.name.startswith(FOLDER_PREFIX)}

    server = start(WORKERS=1)
    left = own(server)
    assert len(left) == 3  # one for each pool of workers
    server.kill()
    assert all(folder.exists() for folder in left)
    again = start(WORKERS=1)
    assert not any(folder.exists() for folder in left)
    mine = own(again)
    again.stop()
    assert not any(folder.exists() for folder in mine)


def test_folders_in_use_and_those_of_others_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / f"{FOLDER_PREFIX}being-made").mkdir()
    (tmp_path / "other").mkdir()
    used = TemporaryFolder()
    dead = tmp_path / f"{FOLDER_PREFIX}dead"
    dead.mkdir()
    (dead / ".in-use").touch()
    stopped = tmp_path / "ipfit-data"  # the data folder of a server that does not run
    stopped.mkdir()
    (stopped / "lock").touch()
    with temporary_folder() as here:
        kept = {f"{FOLDER_PREFIX}being-made", "ipfit-data", "other", used.path.name, here.name}
        assert {one.name for one in tmp_path.iterdir()} == kept
    assert not here.exists()
    used.remove()


def test_all_processes_together_fit_the_machine() -> None:
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    assert 0 < memory.available() <= machine
    server = 2**30
    for processes in (1, 4, 20):
        each = memory.worker_memory(processes, server)
        assert memory.LEAST <= each <= memory.MOST
        assert each in (memory.LEAST, memory.MOST) or each * processes + server < machine


@pytest.mark.parametrize(
    ("line", "files", "expected"),
    [
        ("0::/a/b", {"a/memory.max": "3000", "a/b/memory.max": "max"}, [3000]),
        ("0::/a/b", {"memory.max": "5000", "a/b/memory.max": "4000"}, [4000, 5000]),
        ("0::/on/the/host", {"memory.max": "6000"}, [6000]),
        ("4:memory:/a", {"memory/a/memory.limit_in_bytes": "7000"}, [7000]),
        ("3:cpu:/a", {"cpu/a/memory.limit_in_bytes": "7000"}, []),
        ("0::/", {}, []),
    ],
)
def test_the_limits_of_control_groups(tmp_path: Path, line: str, files: dict[str, str], expected: list[int]) -> None:
    (tmp_path / "own").write_text(f"{line}\n", encoding="ascii")
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="ascii")
    assert memory._limits(tmp_path, tmp_path / "own") == expected  # noqa: SLF001 - no machine has all these


def test_the_server_has_a_limit_of_its_own_and_workers_have_theirs(start: Start) -> None:
    server = start(WORKERS=1, SERVER_MEMORY=2**30, WORKER_MEMORY=3 * 2**30)
    server.fit(npy(ellipse(48)))
    limits = {pid: resource.prlimit(pid, resource.RLIMIT_DATA)[0] for pid in (server.process.pid, *server.workers())}
    assert limits.pop(server.process.pid) == 2**30
    assert set(limits.values()) == {3 * 2**30}


def test_a_fit_whose_mesh_cannot_be_made_at_once_is_accepted_all_the_same(start: Start) -> None:
    server = start(WORKERS=1, WAITING_REQUESTS=1)
    fit = server.fit(npy(torus()), "max_degree=4")
    with ThreadPoolExecutor() as threads:
        meshes = f"{server.url}/v1/fits/{fit['id']}/mesh?resolution="
        asked = [threads.submit(httpx.get, f"{meshes}{256 - i}", timeout=60.0) for i in range(6)]
        until(lambda: any(one.done() and one.result().status_code == 503 for one in asked))
        wanted = NPY | {"Accept": "application/geo+json"}
        answer = server.client.post("/v1/fits?max_degree=2", content=npy(ellipse()), headers=wanted)
    assert answer.status_code == 202, answer.text
    assert answer.json()["status"] == "successful"
    assert server.client.get(f"{answer.headers['Location']}/mesh").is_success


def test_too_many_bytes_on_their_way_in_are_refused(start: Start) -> None:
    server = start(WORKERS=1, TRANSIT_BYTES=2**21)
    body = npy(torus(20_000))
    assert len(body) < 2**20
    answers: list[httpx.Response] = []

    def slowly() -> None:
        def parts() -> Iterator[bytes]:
            yield body[:700_000]
            go_on.wait(30.0)
            yield body[700_000:]

        answers.append(
            httpx.post(f"{server.url}/v1/fits?max_degree=2&geometric=false", content=parts(), headers=NPY, timeout=60.0)
        )

    go_on = threading.Event()
    sender = threading.Thread(target=slowly)
    sender.start()
    until(lambda: any(one.stat().st_size > 600_000 for one in (server.folder / "incoming").iterdir()))
    refused = server.client.post("/v1/fits", content=body, headers=NPY)
    problem(refused, 503, "queue-full")
    assert int(refused.headers["Retry-After"]) >= 1
    other = httpx.HTTPTransport(local_address="127.0.0.9")
    with httpx.Client(base_url=server.url, transport=other, timeout=60.0) as client:
        sent = client.post("/v1/fits?max_degree=2&geometric=false", content=body, headers=NPY)
        assert sent.json()["status"] == "successful"
    go_on.set()
    sender.join()
    assert answers[0].json()["status"] == "successful"
    assert server.client.post("/v1/fits?max_degree=2", content=npy(ellipse()), headers=NPY).status_code == 200


def test_a_full_queue_is_told_before_the_body_is_read(start: Start) -> None:
    server = start(WORKERS=1, QUEUE_BYTES=2**20, CLIENT_SHARE=1)
    at_once = NPY | {"Prefer": "respond-async", "Idempotency-Key": '"one"'}
    long = npy(torus(20_000))
    for i in range(3):
        sent = server.client.post(
            "/v1/fits?t1=0&max_degree=16", content=long, headers=at_once | {"Idempotency-Key": f'"{i}"'}
        )
        assert sent.status_code == 202
    refused = server.client.post("/v1/fits", content=b"never read", headers=JSON)
    assert "the points of fits that wait take" in problem(refused, 503, "queue-full")["detail"]
    again = server.client.post(
        "/v1/fits?t1=0&max_degree=16", content=long, headers=at_once | {"Idempotency-Key": '"1"'}
    )
    assert (again.status_code, again.headers["Idempotency-Replayed"]) == (202, "true")


def test_the_default_memory_of_a_worker_is_a_share() -> None:
    assert Settings().worker_memory is None
