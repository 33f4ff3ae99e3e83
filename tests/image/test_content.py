"""What is in the images, and what is not."""

import pytest

from tests.image.podman import Podman

# Of /opt/venv, in millions of bytes: what there was when this was written, and room for newer releases.
LIMITS = {"plain": 250, "s3": 280}
PACKAGES = "from importlib.metadata import distributions as d; print(*(one.name.lower() for one in d()))"
UNREAD = r"pip|setuptools|tests|__pycache__|.*\.(pyi|pyx|pxd|c|h|a|f|f90)"


def printed(podman: Podman, image: str, *words: str) -> str:
    done = podman.read(image, *words)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("target", LIMITS)
def test_the_environment_is_small(podman: Podman, images: dict[str, str], target: str, seen: list[str]) -> None:
    size = int(printed(podman, images[target], "du", "-s", "-B1", "--apparent-size", "/opt/venv").split()[0])
    seen.append(f"{target}: the environment has {size / 1e6:.0f} MB; {LIMITS[target]} are allowed")
    assert size < LIMITS[target] * 1e6


def test_nothing_is_in_it_that_nobody_reads(podman: Podman, image: str) -> None:
    found = printed(podman, image, "find", "/opt", "-regextype", "posix-extended", "-regex", f".*/({UNREAD})")
    assert not found
    symbols = "import sys; print(*(p for p in sys.argv[1:] if b'\\0.debug_info\\0' in open(p, 'rb').read()))"
    modules = printed(podman, image, "find", "/opt/venv", "-name", "*.so").split()
    assert len(modules) > 100
    assert not printed(podman, image, "python", "-c", symbols, *modules).split()


def test_each_has_the_packages_it_needs_and_no_others(podman: Podman, images: dict[str, str]) -> None:
    packages = {target: set(printed(podman, name, "python", "-c", PACKAGES).split()) for target, name in images.items()}
    assert {"ipfit", "numpy", "scipy", "fastapi"} <= packages["plain"] <= packages["s3"]
    assert {"s3fs", "botocore"} <= packages["s3"] - packages["plain"]
    assert not packages["s3"] & {"pip", "setuptools", "scikit-image", "pillow", "pytest"}


@pytest.mark.parametrize("command", ["openapi", "healthcheck"])
def test_nothing_is_compiled_at_the_start(podman: Podman, image: str, command: str) -> None:
    """Python itself would compile its own modules, too, each time: it cannot write what it compiled."""
    log = podman.read(image, "ipfit", command, PYTHONVERBOSE="1", IPFIT_PORT="1").stderr.splitlines()
    assert sum("code object from '/opt/venv/bytecode/" in line for line in log) > 100
    assert not [line for line in log if "code object from /" in line]


def test_a_changed_file_is_not_hidden_by_the_bytecode_of_the_old_one(podman: Podman, image: str) -> None:
    """Whoever builds on the image and changes a file gets what he wrote, whatever the times of the files say."""
    flags = "import service, numpy, json\nfor one in service, numpy, json: print(open(one.__cached__, 'rb').read(8)[4])"
    assert printed(podman, image, "python", "-c", flags).split() == ["3"] * 3  # PEP 552: by hash, and compared
