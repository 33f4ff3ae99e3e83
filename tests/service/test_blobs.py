"""The blob store: content under its hash, whole or not at all."""

import hashlib
import os
import pickle
import resource
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from uuid import uuid4

import pytest
from fsspec.registry import known_implementations

from service.settings import Settings
from service.store.blobs import Blobs


def files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def test_what_was_put_is_there_under_its_hash(tmp_path: Path) -> None:
    blobs = Blobs(str(tmp_path))
    for content in (b"", b"content", os.urandom(1_000_000)):
        key = blobs.put(content)
        assert key == hashlib.sha256(content).hexdigest()
        assert blobs.get(key) == content
        assert blobs.get(key, 2, 5) == content[2:5]


def test_the_same_content_is_kept_once(tmp_path: Path) -> None:
    blobs = Blobs(str(tmp_path))
    assert blobs.put(b"content") == blobs.put(b"content")
    assert len(files(tmp_path)) == 1


def test_many_who_put_the_same_do_not_disturb_each_other(tmp_path: Path) -> None:
    blobs, content = Blobs(str(tmp_path)), os.urandom(100_000)
    with ThreadPoolExecutor(8) as threads:
        keys = set(threads.map(lambda _: blobs.put(content), range(64)))
    (key,) = keys
    assert blobs.get(key) == content
    assert len(files(tmp_path)) == 1  # nothing half-written is left


def test_what_was_deleted_is_gone_and_may_be_deleted_again(tmp_path: Path) -> None:
    blobs = Blobs(str(tmp_path))
    key = blobs.put(b"content")
    for _ in range(2):
        blobs.delete(key)
        assert not files(tmp_path)
    with pytest.raises(FileNotFoundError):
        blobs.get(key)


def test_a_worker_gets_the_same_store(tmp_path: Path) -> None:
    blobs = Blobs(str(tmp_path))
    assert pickle.loads(pickle.dumps(blobs)).get(blobs.put(b"content")) == b"content"  # noqa: S301 - our own


def test_any_file_system_will_do() -> None:
    blobs = Blobs(f"memory://{uuid4().hex}")
    key = blobs.put(b"content")
    assert blobs.get(key) == b"content"
    blobs.delete(key)
    with pytest.raises(FileNotFoundError):
        blobs.get(key)


def test_a_put_that_fails_leaves_nothing_behind(tmp_path: Path) -> None:
    blobs, before = Blobs(str(tmp_path)), resource.getrlimit(resource.RLIMIT_FSIZE)
    kept = blobs.put(b"content")
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))  # the kernel refuses to write more
    try:
        with pytest.raises(OSError, match="File too large"):
            blobs.put(os.urandom(100_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [path.name for path in files(tmp_path)] == [kept]


def test_keys_are_those_of_whole_blobs_and_old_halves_are_cleared_away(tmp_path: Path) -> None:
    blobs = Blobs(str(tmp_path))
    assert blobs.keys() == []
    keys = {blobs.put(b"one"), blobs.put(b"two")}
    for name, age in (("fresh", 0.0), ("old", 7200.0)):
        half = tmp_path / "ab" / f"{64 * 'a'}.{name}"
        half.parent.mkdir(exist_ok=True)
        half.write_bytes(b"ha")
        os.utime(half, (time.time() - age,) * 2)
    (tmp_path / "README").write_text("somebody else's", encoding="utf-8")
    assert set(blobs.keys()) == keys
    assert {path.name for path in files(tmp_path)} == {*keys, f"{64 * 'a'}.fresh", "README"}


def test_storage_whose_package_is_missing_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IPFIT_BLOBS_URL", "s3://bucket")
    assert Settings().blobs_url == "s3://bucket"
    monkeypatch.setitem(known_implementations, "s3", {"class": "missing_package.S3", "err": "Install it"})
    with pytest.raises(ValueError, match=r"s3:// is not installed.*ipfit\[s3\]"):
        Settings()
    for url in ("/folder", "file:///folder", "memory://folder"):
        monkeypatch.setenv("IPFIT_BLOBS_URL", url)
        assert Settings().blobs_url == url
