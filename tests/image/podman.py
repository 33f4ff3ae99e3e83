"""podman with a storage of its own: what it builds and runs here leaves nothing behind.

For root, each call gets a mount namespace of its own, so that the mounts of the storage go with it. Where both versions
of cgroups are mounted, version 2 is hidden there, because crun refuses such a mixture; nothing here is limited by them.
"""

import os
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import IO

ROOT = Path(__file__).parents[2]
_HIDING = 'umount /sys/fs/cgroup/unified 2>/dev/null; exec "$@"'
_OWN_MOUNTS = ("unshare", "--mount", "sh", "-c", _HIDING, "-")
# podman asks for as much, or for more than there is; where it may not, it starts nothing.
_MOST = {"nofile": (resource.RLIMIT_NOFILE, 2**20), "nproc": (resource.RLIMIT_NPROC, 2**15)}
# A pipe as standard input: crun gives what is there to the user of the container, and else that is /dev/null itself.
PIPED = "--interactive"
CONFINED = (
    *("--read-only", "--read-only-tmpfs=false", "--tmpfs=/tmp"),
    *("--cap-drop=all", "--security-opt=no-new-privileges", "--passwd=false"),
)


class PodmanError(Exception):
    """podman failed, or is missing."""


class Podman:
    """The program, and a folder for its images and containers."""

    def __init__(self) -> None:
        """Make the folder.

        Raises
        ------
        PodmanError
            If podman is not installed.

        """
        if shutil.which("podman") is None:
            raise PodmanError("podman is not installed")
        self._folder = Path(tempfile.mkdtemp(prefix="ipfit-image-"))  # podman wants a path below 50 characters
        own = () if os.geteuid() else _OWN_MOUNTS
        places = (f"--root={self._folder / 'storage'}", f"--runroot={self._folder / 'run'}")
        self._podman = (*own, "podman", *places, "--cgroup-manager=cgroupfs", "--log-level=fatal")

    def __call__(self, *words: str, stdin: IO[bytes] | None = None, seconds: float = 60.0) -> str:
        """Call podman and return what it wrote to standard output.

        Raises
        ------
        PodmanError
            If it fails.

        """
        done = subprocess.run(  # noqa: S603 - podman, with arguments of these tests
            [*self._podman, *words], stdin=stdin, capture_output=True, text=True, timeout=seconds, check=False
        )
        if done.returncode:
            raise PodmanError(f"podman {words[0]}: {done.stdout[-4000:]}{done.stderr[-4000:]}")
        return done.stdout

    def run_command(self, image: str, *words: str, user: str, options: tuple[str, ...] = ()) -> list[str]:
        """Return the command that runs an image with as few rights as a cluster would give it."""
        limits = []
        for name, (limit, most) in _MOST.items():
            soft, hard = (most if one == resource.RLIM_INFINITY else one for one in resource.getrlimit(limit))
            limits.append(f"--ulimit={name}={min(soft, most)}:{min(hard, most)}")
        usual = ("run", PIPED, "--rm", "--pull=never", "--network=host", "--cgroups=disabled", "--no-healthcheck")
        return [*self._podman, *usual, *limits, *CONFINED, f"--user={user}", *options, image, *words]

    def read(self, image: str, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """Run one program of an image to its end, as a user that the image does not know."""
        options = ["--entrypoint=", *(f"--env={name}={value}" for name, value in environment.items())]
        command = self.run_command(image, *words, user="12345:0", options=tuple(options))
        return subprocess.run(command, input="", capture_output=True, text=True, timeout=60.0, check=False)  # noqa: S603 - as above

    def remove(self) -> None:
        """Remove all containers, and the folder with the images and volumes."""
        self("rm", "--all", "--force", "--volumes")
        if os.geteuid():  # files of other users of a container belong to numbers that only podman may use
            self("unshare", "rm", "-rf", str(self._folder))
        shutil.rmtree(self._folder, ignore_errors=bool(os.geteuid()))
