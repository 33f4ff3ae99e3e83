"""The images at work: as any user, without rights, with nothing to write but /data and /tmp."""

import time
from io import BytesIO

import numpy as np
import pytest
import trimesh

from tests.image.conftest import Start
from tests.image.container import Container
from tests.image.podman import Podman, PodmanError
from tests.service.bodies import ellipse, npy, sphere
from tests.service.posted import values

CONFINED = """
import os, pathlib, pwd
status = dict(line.split(":\\t", 1) for line in pathlib.Path("/proc/self/status").read_text().splitlines())
print(os.getuid(), os.getgid(), int(status["CapBnd"], 16), status["NoNewPrivs"])
print(12345 in {one.pw_uid for one in pwd.getpwall()})
for folder, _, _ in os.walk("/"):
    if os.access(folder, os.W_OK) and not folder.startswith(("/proc", "/dev", "/sys")):
        print(folder)
"""


def check_fits(server: Container) -> str:
    """Fit an outline and a surface, check the answers, and return the id of the second."""
    fit = server.fit(npy(ellipse()))
    assert fit["polynomial"]["degree"] == 2
    assert np.abs(values(fit, ellipse(97))).max() < 1e-3
    assert values(fit, np.array([[2.5, 1.0]]))[0] < -0.1
    surface = server.fit(npy(sphere()))
    mesh = server.client.get(f"/v1/fits/{surface['id']}/mesh", params={"format": "stl"})
    assert mesh.status_code == 200, mesh.text
    ball = trimesh.load_mesh(BytesIO(mesh.content), file_type="stl")
    assert isinstance(ball, trimesh.Trimesh)
    assert ball.volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.05)
    return str(surface["id"])


def test_any_user_without_rights_fits_with_a_folder_in_tmp(start: Start, image: str) -> None:
    server = start(image, DATA_DIR="/tmp/ipfit")  # noqa: S108 - of the container
    server.await_ready()
    user, known, *writable = server.run("python", "-c", CONFINED).splitlines()
    assert user == "12345 0 0 1"
    assert known == "False"
    assert {one for one in writable if not one.startswith("/tmp/")} <= {"/data", "/tmp"}  # noqa: S108 - as above
    assert server.client.get("/livez").status_code == 200
    check_fits(server)
    server.run("ipfit", "healthcheck")
    with pytest.raises(PodmanError, match="not ready"):
        server.run("env", "IPFIT_PORT=1", "ipfit", "healthcheck")
    began = time.monotonic()
    server.stop()
    assert time.monotonic() - began < 5.0


@pytest.mark.parametrize("user", ["", "12345:0"], ids=["its own user", "any user"])
def test_fits_on_a_volume_outlive_the_container(
    start: Start, images: dict[str, str], podman: Podman, user: str
) -> None:
    volume = podman("volume", "create").strip()
    first = start(images["plain"], user=user, options=(f"--volume={volume}:/data",))
    first.await_ready()
    fit = check_fits(first)
    assert "/data/fits.sqlite" in first.run("find", "/data").split()
    assert not first.run("find", "/data", "-mindepth", "1", "-perm", "/077")  # others of the group read nothing
    first.stop()
    second = start(images["plain"], user=user, options=(f"--volume={volume}:/data",))
    second.await_ready()
    assert second.client.get(f"/v1/fits/{fit}").json()["status"] == "successful"
    second.stop()
    other = start(images["plain"], user="23456:0", options=(f"--volume={volume}:/data",))
    assert other.ended() != 0
    assert "cannot be written by user 23456 of group 0" in other.log


def test_a_volume_of_another_user_is_refused_with_a_reason(
    start: Start, images: dict[str, str], podman: Podman
) -> None:
    volume = podman("volume", "create").strip()
    server = start(images["plain"], user="12345:12345", options=(f"--volume={volume}:/data",))
    assert server.ended() != 0
    assert "/data/incoming cannot be written by user 12345 of group 12345" in server.log
