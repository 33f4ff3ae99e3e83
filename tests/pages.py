"""The Markdown pages of this repository: their examples, tables, links and drawings."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
RUN_BY = ("python", "sh")
PROGRAMS = ("bash", "curl", "python3")  # what the examples in `sh` call


def blocks(page: Path, *languages: str) -> list[tuple[str, str]]:
    """Return the language and the text of each code block of a page that is in one of these languages."""
    found: list[tuple[str, str]] = BLOCK.findall(page.read_text(encoding="utf-8"))
    return [(language, text) for language, text in found if language in languages]


def rows(page: Path, head: str) -> list[list[str]]:
    """Return the cells of the rows below the first table line that starts with `head`."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith(head)) + 2
    end = next((number for number in range(start, len(lines)) if not lines[number].startswith("|")), len(lines))
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[start:end]]


def code(cell: str) -> list[str]:
    """Return what stands in backticks in a cell."""
    return re.findall(r"`([^`]+)`", cell)


def skip_without_programs() -> None:
    """Skip the test, with the reason, if a program that the examples call is missing here."""
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing:
        pytest.skip(f"the examples call {' and '.join(missing)}, not installed here")


def run_examples(page: Path, server: str, folder: Path) -> str:
    """Run the examples of a page in their order, in a folder, against a server; return all that they print."""
    here = f"{Path(sys.executable).parent}{os.sep}"
    outputs = []
    for language, text in blocks(page, *RUN_BY):
        adapted = text.replace("http://127.0.0.1:8000", server).replace(".venv/bin/", here)
        outputs.append(_run(language, adapted, folder))
    return "\n".join(outputs)


def _run(language: str, text: str, folder: Path) -> str:
    command = [sys.executable, "-c", text] if language == "python" else ["bash", "-euo", "pipefail", "-c", text]
    done = subprocess.run(  # noqa: S603 - the pages' own commands
        command, cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, f"{text}\n{done.stderr}"
    return done.stdout
