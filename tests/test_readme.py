"""Every command and every example of the README, run in its order against a real server."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh

from service.settings import table

README = Path(__file__).parent.parent / "README.md"
PROGRAMS = ("bash", "curl")  # that the examples use
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def run(kind: str, code: str, folder: Path) -> str:
    command = [sys.executable, "-c", code] if kind == "python" else ["bash", "-euo", "pipefail", "-c", code]
    done = subprocess.run(  # noqa: S603 - the README's own commands
        command, cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, f"{code}\n{done.stderr}"
    return done.stdout


def test_every_example_works_as_written(server: str, tmp_path: Path) -> None:
    if missing := [name for name in PROGRAMS if shutil.which(name) is None]:
        pytest.skip(f"THE EXAMPLES OF THE README WERE NOT TESTED: there is no {' and no '.join(missing)} here")
    here = f"{Path(sys.executable).parent}{os.sep}"
    outputs = []
    for kind, code in BLOCK.findall(README.read_text(encoding="utf-8")):
        adapted = code.replace("http://127.0.0.1:8000", server).replace(".venv/bin/", here)
        outputs.append(run(kind, adapted, tmp_path))
    output = "\n".join(outputs)
    assert '"degree":2' in output
    assert "[ True]" in output  # the cell's centre is inside
    assert "criterion-met" in output
    assert "[ True False]" in output  # the torus's core circle is inside, the other point is not
    for name in ("torus.glb", "torus.ply"):
        mesh = trimesh.load_mesh(tmp_path / name)
        assert mesh.is_watertight
        assert mesh.euler_number == 0
    assert (tmp_path / "torus.svg").read_bytes().startswith(b"<svg")


def test_the_table_of_settings_is_that_of_the_code() -> None:
    assert table() in README.read_text(encoding="utf-8")
