"""The examples of docs/extending.md, applied one by one to a copy of the repository, whose tests they bring along."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.pages import ROOT, blocks

PAGE = ROOT / "docs" / "extending.md"
COPIED = ("ipcore", "service", "tests", "pyproject.toml")
SECTIONS = [part for part in PAGE.read_text(encoding="utf-8").split("\n## ") if part.startswith("Add ")]
MOST_FILES = {"family": 2, "criterion": 2, "format": 2, "endpoint": 3}  # that an addition touches, its test apart


def applied(section: str, folder: Path) -> list[str]:
    """Write the files and make the changes of a section in a copy of the repository; return what was touched."""
    page = folder / "section.md"
    page.write_text(section, encoding="utf-8")
    touched = []
    for language, text in blocks(page, "python", "diff"):
        if language == "python":
            name, _, content = text.removeprefix("# ").partition("\n")
            (folder / name).write_text(content, encoding="utf-8")
            touched.append(name)
        else:
            touched += changed(text, folder)
    return touched


def changed(diff: str, folder: Path) -> list[str]:
    """Make the changes of a diff. Each hunk follows a line with `---`, and a file's first one names the file."""
    names: list[str] = []
    for head, hunk in re.findall(r"^---(.*)\n((?:(?!---).*\n)*)", diff, re.MULTILINE):
        names += [head.strip()] if head.strip() else []
        lines = [(line[:1], line[1:]) for line in hunk.splitlines()]
        before = "".join(f"{text}\n" for sign, text in lines if sign != "+")
        after = "".join(f"{text}\n" for sign, text in lines if sign != "-")
        file = folder / names[-1]
        content = file.read_text(encoding="utf-8")
        assert content.count(before) == 1, f"{names[-1]} does not have, once:\n{before}"
        file.write_text(content.replace(before, after), encoding="utf-8")
    return names


def run(folder: Path, module: str, *arguments: str) -> None:
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("COV_", "COVERAGE_", "PYTEST_"))}
    done = subprocess.run(  # noqa: S603 - our own tools
        [sys.executable, "-m", module, *arguments],
        cwd=folder,
        env=kept | {"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_short_page_names_the_files_that_the_examples_touch() -> None:
    short = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert len(short.splitlines()) <= 100
    for section in SECTIONS:
        for _, text in blocks_of(section, "diff"):
            for name in re.findall(r"^--- (\S+)", text, re.MULTILINE):
                assert f"({name})" in short, name


def blocks_of(section: str, *languages: str) -> list[tuple[str, str]]:
    found = re.findall(r"^```(\w+)\n(.*?)^```", section, re.MULTILINE | re.DOTALL)
    return [one for one in found if one[0] in languages]


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.partition("\n")[0])
@pytest.mark.timeout(300)
def test_an_addition_works_as_it_is_shown(section: str, tmp_path: Path) -> None:
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    touched = applied(section, tmp_path)
    tests = [name for name in touched if name.startswith("tests/")]
    assert len(tests) == 1
    (most,) = [count for word, count in MOST_FILES.items() if word in section.partition("\n")[0]]
    assert len(set(touched) - set(tests)) <= most
    run(tmp_path, "ruff", "check", *touched)
    run(tmp_path, "ruff", "format", "--check", *touched)
    run(tmp_path, "pytest", "-q", "-p", "no:cacheprovider", *tests)
