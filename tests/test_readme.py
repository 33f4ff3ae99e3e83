"""Every command and every example of the README, run as it stands there, in its order, against a real server."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import trimesh

from tests.pages import DOCS, README, ROOT, run_examples, skip_without_programs

HEADLINE = re.compile(r'<text id="headline".*?</text>')


@pytest.mark.timeout(300)
def test_every_example_works_as_written(server: str, tmp_path: Path) -> None:
    skip_without_programs()
    told = run_examples(README, server, tmp_path)
    fit = (tmp_path / "horse.json").read_text(encoding="utf-8")
    assert '"status":"successful"' in fit
    assert "[ True]" in told  # the point in the horse's body is inside
    assert '"stop_reason": "criterion-met"' in (tmp_path / "torus.json").read_text(encoding="utf-8")
    for name in ("torus.glb", "torus.ply"):
        mesh = trimesh.load_mesh(tmp_path / name)
        assert mesh.is_watertight
        assert mesh.euler_number == 0
    shown, made = ((folder / "horse.svg").read_text(encoding="utf-8") for folder in (DOCS, tmp_path))
    # the picture at the top is what the commands make: the same degree, coefficients and distances
    assert HEADLINE.findall(shown) == HEADLINE.findall(made) != []


def test_the_two_commands_are_targets_of_make() -> None:
    make = shutil.which("make")
    if make is None:
        pytest.skip("the README's first commands call make, not installed here")
    for target in ("serve", "test"):
        assert f"make {target} " in README.read_text(encoding="utf-8")
        done = subprocess.run(  # noqa: S603 - our own Makefile
            [make, "--dry-run", target], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
        )
        assert done.returncode == 0, done.stderr
