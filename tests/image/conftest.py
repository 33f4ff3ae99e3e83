"""The images, built once; `make image-check` runs what is here, and nothing else does."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.image.base import base_image, pip_volumes
from tests.image.container import Container
from tests.image.podman import ROOT, Podman, PodmanError

HERE = Path(__file__).parent
Start = Callable[..., Container]
SEEN = pytest.StashKey[list[str]]()


def pytest_ignore_collect(config: pytest.Config) -> bool | None:
    """Leave these tests out unless this folder or one of its files is named: they take minutes and want podman."""
    named = [(config.invocation_params.dir / one.partition("::")[0]).resolve() for one in config.args]
    return None if any(one.is_relative_to(HERE) for one in named) else True


def pytest_configure(config: pytest.Config) -> None:
    config.stash[SEEN] = []


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say in the end how large the images are, or that none was built."""
    for line in config.stash[SEEN]:
        terminalreporter.write_line(f"image-check: {line}")


@pytest.fixture(scope="session")
def seen(pytestconfig: pytest.Config) -> list[str]:
    """Return the lines that are printed in the end."""
    return pytestconfig.stash[SEEN]


@pytest.fixture(scope="session")
def podman(seen: list[str]) -> Iterator[Podman]:
    """Return podman; skip all tests, and say so, where it is missing or may not run anything."""
    try:
        one = Podman()
    except PodmanError as error:
        seen.append(f"NOT BUILT, NOT RUN: {error}")
        pytest.skip(str(error))
    yield one
    one.remove()


@pytest.fixture(scope="session")
def base(podman: Podman, seen: list[str]) -> str:
    """Return the name of the image to build on; skip all tests, and say so, where none can be had, or run."""
    try:
        name = base_image(podman)
        tried = podman.read(name, "true")
        if tried.returncode:
            raise PodmanError(f"podman runs no containers here: {tried.stderr}")  # noqa: TRY301 - one reason like the other
    except PodmanError as error:
        seen.append(f"NOT BUILT, NOT RUN: {error}")
        pytest.skip(str(error))
    return name


@pytest.fixture(scope="session")
def images(podman: Podman, base: str, seen: list[str], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Build both images and return their names, by their targets."""
    names = {"plain": "localhost/ipfit:plain", "s3": "localhost/ipfit:s3"}
    given = pip_volumes(tmp_path_factory.mktemp("pip"))
    usual = ("build", "--isolation=chroot", "--format=docker", "--pull=never", f"--build-arg=PYTHON_IMAGE={base}")
    for target, name in names.items():
        chosen = () if target == "plain" else (f"--target={target}",)  # plain is what one gets without asking
        podman(*usual, *given, *chosen, f"--tag={name}", str(ROOT), seconds=900.0)
        (about,) = json.loads(podman("image", "inspect", name))
        seen.append(f"{target}: the image has {about['Size'] / 1e6:.0f} MB, with its base")
    return names


@pytest.fixture(params=["plain", "s3"])
def image(images: dict[str, str], request: pytest.FixtureRequest) -> str:
    """Return the name of each image."""
    return images[request.param]


@pytest.fixture
def start(podman: Podman, tmp_path: Path) -> Iterator[Start]:
    """Return a function that starts a container: image, command, and what `Container` takes."""
    started: list[Container] = []

    def one(image: str, command: str = "serve", **more: object) -> Container:
        started.append(Container(podman, image, command, tmp_path, **more))  # type: ignore[arg-type]  # passed on as given
        return started[-1]

    yield one
    for container in started:
        container.end()
