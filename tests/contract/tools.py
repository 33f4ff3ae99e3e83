"""Programs that the tests of the contract run; `make contract` installs them beside the project's own environment."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
DOCUMENT = ROOT / "openapi" / "openapi.json"
PYTHON_TOOLS = ROOT / ".venv-contract" / "bin"
NODE_TOOLS = HERE / "node_modules" / ".bin"
LEAST_NODE = (20, 19)  # redocly's and openapi-typescript's
QUIET = {"REDOCLY_TELEMETRY": "off", "REDOCLY_SUPPRESS_UPDATE_NOTICE": "true"}


def run(*command: str | Path, folder: Path = ROOT, **environment: str) -> str:
    """Run a program, which must succeed, and return what it printed."""
    path = f"{PYTHON_TOOLS}:{os.environ['PATH']}"  # openapi-python-client calls ruff
    done = subprocess.run(  # noqa: S603 - programs of the locks, or node
        list(map(str, command)),
        cwd=folder,
        env={**os.environ, "PATH": path, **QUIET, **environment},
        capture_output=True,
        text=True,
        timeout=240.0,
        check=False,
    )
    assert done.returncode == 0, f"{command[0]}:\n{done.stdout}\n{done.stderr}"
    return done.stdout


def need_node() -> str:
    """Return the path of node; skip the test if it is missing, too old, or its packages are not installed."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed here")
    found = re.match(r"v(\d+)\.(\d+)", run(node, "--version"))
    if found is None or tuple(map(int, found.groups())) < LEAST_NODE:
        pytest.skip(f"node is older than {'.'.join(map(str, LEAST_NODE))}")
    if not NODE_TOOLS.is_dir():
        pytest.skip("tests/contract/node_modules is missing: make contract")
    return node


def need_python_tools() -> None:
    """Skip the test if the generators are not installed."""
    if not PYTHON_TOOLS.is_dir():
        pytest.skip(".venv-contract is missing: make contract")


def need_java() -> None:
    """Skip the test if there is no Java."""
    if shutil.which("java") is None:
        pytest.skip("java is not installed here")
