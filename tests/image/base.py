"""The image to build on: the one that the Dockerfile names, or, where no registry answers, a Debian with its Python."""

import os
import re
import shutil
import subprocess
import tarfile
from pathlib import Path

from tests.image.podman import ROOT, Podman, PodmanError

LOCAL = "localhost/python:debian"
_KEPT = ROOT / "build" / "image-base.tar"  # it takes minutes to make; `make clean` removes it
_SUITE = "trixie"  # has the Python of the image that the Dockerfile names
_PACKAGES = "python3,python3-venv,ca-certificates"


def base_image(podman: Podman) -> str:
    """Return the name of the image.

    Raises
    ------
    PodmanError
        If none can be had.

    """
    found = re.search("^ARG PYTHON_IMAGE=(.+)$", (ROOT / "Dockerfile").read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None
    try:
        podman("pull", "--quiet", f"docker.io/library/{found[1]}", seconds=240.0)
    except (PodmanError, subprocess.TimeoutExpired) as error:
        if os.geteuid() or shutil.which("debootstrap") is None:
            raise PodmanError(f"no base image: not root, or no debootstrap; and {error}") from error
        if not _KEPT.exists():
            _bootstrap()
        with _KEPT.open("rb") as file:
            podman("import", "--change", "ENV PATH=/usr/local/bin:/usr/sbin:/usr/bin", "-", LOCAL, stdin=file)
        return LOCAL
    return f"docker.io/library/{found[1]}"


def _bootstrap() -> None:
    """Make the Debian, as a tar file."""
    system = _KEPT.with_suffix("")
    shutil.rmtree(system, ignore_errors=True)
    system.parent.mkdir(exist_ok=True)
    try:
        command = ["debootstrap", "--variant=minbase", f"--include={_PACKAGES}", _SUITE, str(system)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600.0, check=False)  # noqa: S603 - a program of Debian
        if done.returncode:
            raise PodmanError(f"no base image: debootstrap fails: {done.stdout[-2000:]}{done.stderr[-2000:]}")
        (system / "usr" / "bin" / "python").symlink_to("python3")
        with tarfile.open(_KEPT.with_suffix(".part"), "w") as tar:
            tar.add(system, ".", filter=lambda one: None if "/apt/archives/" in one.name else one)
        _KEPT.with_suffix(".part").rename(_KEPT)
    finally:
        shutil.rmtree(system, ignore_errors=True)


def pip_volumes(folder: Path) -> list[str]:
    """Return the options that give pip in the builder the index and the certificates that pip has here."""
    done = subprocess.run(["python3", "-m", "pip", "config", "list"], capture_output=True, text=True, check=True)  # noqa: S607 - any pip
    found = dict(re.findall(r"^(?:global|:env:)\.([a-z-]+)='(.*)'$", done.stdout, re.MULTILINE))
    told = {name: found[name] for name in ("index-url", "proxy", "timeout", "trusted-host") if name in found}
    options = []
    if "cert" in found:
        told["cert"] = "/etc/pip-certificates.pem"
        options.append(f"--volume={found['cert']}:{told['cert']}:ro")
    (folder / "pip.conf").write_text("\n".join(["[global]", *(f"{name} = {told[name]}" for name in told), ""]))
    return [*options, f"--volume={folder / 'pip.conf'}:/etc/pip.conf:ro"]
