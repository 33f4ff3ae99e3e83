"""The fork server has loaded all that fits need: what one worker would load, each of them would load again."""

import subprocess
import sys

import pytest

from service.workers import fork_server

# Fits of the plane and of space, with their zero sets, after what the fork server loads; prints what they load more.
FITTED = """
import importlib, sys
for name in {preload!r}:
    importlib.import_module(name)
import ipcore
from ipcore import shapes
before = set(sys.modules)
for shape in (shapes.cubic(), shapes.torus()):
    ipcore.fit(*shape.sample(600), options=ipcore.FitOptions(max_degree=4))
print(*sorted(name for name in set(sys.modules) - before if name.startswith(("scipy.", "numpy.", "ipcore."))))
"""


@pytest.mark.parametrize(("preload", "missing"), [(fork_server.PRELOAD, ""), (["ipcore"], "scipy.ndimage")])
def test_a_fit_loads_nothing_that_the_fork_server_has_not_loaded(preload: list[str], missing: str) -> None:
    command = [sys.executable, "-c", FITTED.format(preload=preload)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - a command of our own
    assert not done.returncode, done.stderr
    assert missing in done.stdout.split() if missing else not done.stdout.split()
