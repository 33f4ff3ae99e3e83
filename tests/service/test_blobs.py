"""The blob folder: content under its own name, whole or not at all."""

import hashlib
import os
import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from uuid import uuid4

import pytest

from service.store.blobs import Blobs


def files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def test_what_was_put_is_there_under_its_hash(tmp_path: Path) -> None:
    blobs = Blobs(str(tmp_path))
    for content in (b"", b"content", os.urandom(1_000_000)):
        key = blobs.put(content)
        assert key == hashlib.sha256(content).hexdigest()
        assert blobs.get(key) == content


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
