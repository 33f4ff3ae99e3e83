"""Point sets in an S3: stored as durably as in a folder, with errors that may pass."""

import os
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from uuid import uuid4

import pytest
from fsspec.exceptions import FSTimeoutError

import ipcore
from service.jobs.errors import NotReadyError
from service.jobs.fit import PointSetRef
from service.store.blobs import Blobs
from service.workers import tasks
from tests.service.bodies import ellipse, npy
from tests.service.clusters import Cluster
from tests.service.postgres import Postgres
from tests.service.running import until
from tests.service.s3 import BUCKET, S3

NPY = {"Content-Type": "application/x-npy"}


@pytest.fixture(scope="module")
def server() -> Iterator[S3]:
    one = S3()
    yield one
    one.kill()


@pytest.fixture
def s3(server: S3, monkeypatch: pytest.MonkeyPatch) -> S3:
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)
    return server


@pytest.fixture
def url(s3: S3) -> str:
    """Return a folder of a test's own."""
    del s3  # it runs, and that is all
    return f"s3://{BUCKET}/{uuid4().hex}"


def test_what_was_put_is_there_until_it_is_deleted(url: str) -> None:
    blobs = Blobs(url)
    contents = [b"", b"content", os.urandom(2_000_000)]
    keys = [blobs.put(content) for content in contents]
    assert [blobs.put(content) for content in contents] == keys
    assert [blobs.get(key) for key in keys] == contents
    assert [blobs.get(key, 2, 5) for key in keys[1:]] == [content[2:5] for content in contents[1:]]
    assert sorted(blobs.keys()) == sorted(keys)
    for _ in range(2):
        blobs.delete(keys[0])
    assert sorted(blobs.keys()) == sorted(keys[1:])
    with pytest.raises(FileNotFoundError):
        blobs.get(keys[0])


def test_many_who_put_the_same_do_not_disturb_each_other(url: str) -> None:
    blobs, content = Blobs(url), os.urandom(100_000)
    with ThreadPoolExecutor(8) as threads:
        (key,) = set(threads.map(lambda _: blobs.put(content), range(32)))
    assert blobs.keys() == [key]
    assert blobs.get(key) == content


def test_a_bucket_that_is_not_there_is_an_error_and_is_not_made(s3: S3) -> None:
    del s3  # it runs, and that is all
    for _ in range(2):
        with pytest.raises(FileNotFoundError, match="bucket"):
            Blobs("s3://elsewhere/folder").put(b"content")


def test_an_s3_that_says_nothing_is_not_waited_for_long(s3: S3, url: str) -> None:
    blobs = Blobs(url, patience=0.5)
    key = blobs.put(b"content")
    s3.hang()
    try:
        began = time.monotonic()
        with pytest.raises(FSTimeoutError):
            blobs.put(b"other")
        with pytest.raises(NotReadyError, match="cannot be read"):
            tasks.fit(blobs, PointSetRef(key, 2, 9), ipcore.FitOptions())
        assert time.monotonic() - began < 20.0  # its own patience is minutes
    finally:
        s3.go_on()
    assert blobs.get(key) == b"content"


def test_a_cluster_whose_s3_is_away_accepts_nothing_and_loses_nothing(
    tmp_path: Path, postgres: Postgres, s3: S3, url: str
) -> None:
    cluster = Cluster(tmp_path, postgres, BLOBS_URL=url)
    try:
        server = cluster.serve()
        fit = server.fit(npy(ellipse()), prefer="respond-async")
        s3.kill()
        answer = server.client.post("/v1/fits", content=npy(ellipse(61)), headers=NPY)
        assert (answer.status_code, answer.json()["type"]) == (503, "/problems/not-ready"), answer.text
        assert "Retry-After" in answer.headers
        worker = cluster.work()
        until(lambda: "cannot be read" in worker.log)
        assert server.look(fit)["status"] in {"accepted", "running"}
        s3.start()
        until(lambda: server.client.post("/v1/fits", content=npy(ellipse()), headers=NPY).is_success)  # its points
        assert server.look(fit, wait=60)["status"] == "successful"
        assert server.client.get(f"/v1/fits/{fit['id']}/mesh").is_success
        assert cluster.count() == 2
    finally:
        cluster.end()
