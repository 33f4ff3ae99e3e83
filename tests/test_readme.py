"""Every command and every example of the README, run as it stands there, in its order, against a real server."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import trimesh

from tests.pages import DOCS, README, ROOT, run_examples, skip_without_programs

DEGREE = re.compile(r'<text id="headline".*?>degree (\d+)<.*?criterion-met</text>')


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
    # The picture at the top is what the commands make, but for the degree: the fit of the horse is not convex, and
    # processors round differently: machines have been seen to end at 15, 16 and 17.
    shown, made = (degree_in(folder / "horse.svg") for folder in (DOCS, tmp_path))
    assert abs(shown - made) <= 2


def degree_in(picture: Path) -> int:
    found = DEGREE.search(picture.read_text(encoding="utf-8"))
    assert found is not None, "the headline has no degree, or the fit did not meet the criterion"
    return int(found.group(1))


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
