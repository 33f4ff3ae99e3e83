"""A server and a worker of each image, around a PostgreSQL: point sets in a folder, or in an S3."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.image.conftest import Start
from tests.image.podman import Podman
from tests.service.bodies import ellipse, npy
from tests.service.postgres import Postgres
from tests.service.s3 import BUCKET, S3

SETTINGS = {"DATA_DIR": "/tmp/ipfit", "LEASE": 3}  # noqa: S108 - of the container


@pytest.fixture(scope="module")
def database() -> Iterator[tuple[str, str]]:
    """Return the URL of a database, and the folder with its socket, which other users may reach."""
    server = Postgres()
    url = server.url("postgres")
    folder = url.partition("host=")[2]
    Path(folder).chmod(0o711)
    yield url, folder
    server.remove()


@pytest.fixture
def s3() -> Iterator[S3]:
    server = S3()
    yield server
    server.kill()


def fit_in_a_cluster(start: Start, image: str, options: tuple[str, ...], given: dict[str, object]) -> None:
    server = start(image, options=options, **given, **SETTINGS)
    server.await_ready()
    worker = start(image, "worker", options=options, **given, **SETTINGS)
    worker.await_ready()
    assert server.fit(npy(ellipse()))["polynomial"]["degree"] == 2
    worker.stop()
    server.stop()


def test_with_point_sets_in_a_folder(
    start: Start, images: dict[str, str], database: tuple[str, str], podman: Podman
) -> None:
    options = (f"--volume={database[1]}:{database[1]}", f"--volume={podman('volume', 'create').strip()}:/data")
    given: dict[str, object] = {"DATABASE_URL": database[0], "BLOBS_URL": "file:///data"}
    fit_in_a_cluster(start, images["plain"], options, given)


def test_with_point_sets_in_an_s3(start: Start, images: dict[str, str], database: tuple[str, str], s3: S3) -> None:
    options = (f"--volume={database[1]}:{database[1]}",)
    given: dict[str, object] = {"DATABASE_URL": database[0], "BLOBS_URL": f"s3://{BUCKET}/image"}
    fit_in_a_cluster(start, images["s3"], options, given | {"environment": s3.environment})


def test_the_image_without_s3_says_so(start: Start, images: dict[str, str]) -> None:
    server = start(images["plain"], BLOBS_URL="s3://ipfit", **SETTINGS)
    assert server.ended() == 2
    assert "the package for s3:// is not installed" in server.log
