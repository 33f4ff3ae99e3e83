"""The table of docs/mathematics.md that says where to find what, held to the code."""

import re

import pytest

from tests.pages import DOCS, ROOT

PAGE = (DOCS / "mathematics.md").read_text(encoding="utf-8")
TABLE = PAGE[PAGE.index("### Where to find it") :]
ROWS = [row.strip("|").split("|") for row in re.findall(r"^\|.*\]\(.*$", TABLE, re.MULTILINE)]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0].strip())
def test_every_file_exists_and_the_names_are_in_them(row: list[str]) -> None:
    files = [(DOCS / link).resolve() for link in re.findall(r"\]\(([^)]+)\)", row[1])]
    assert files
    assert all(file.is_file() for file in files)
    code = "".join(file.read_text(encoding="utf-8") for file in files)
    for name in re.findall(r"`([^`]+)`", row[1]):
        assert re.search(rf"\b(def|class) {name}\b|^{name}\b|\b{name}\(", code, re.MULTILINE), name


def test_every_file_that_raises_a_413_is_in_its_row() -> None:
    (row,) = [row for row in ROWS if "413" in row[0]]
    raising = [
        path
        for path in (ROOT / "service").rglob("*.py")
        if re.search(r"(raise|return) TooLargeError\(", path.read_text(encoding="utf-8"))
    ]
    assert raising
    for path in raising:
        assert path.name in row[1], path.name


@pytest.mark.parametrize(
    "asked",
    ["stopping rule", "evaluation of f", "reading a PLY", "status changes", "killing a worker", "polishing", "413"],
)
def test_what_newcomers_ask_for_first_is_in_it(asked: str) -> None:
    assert any(asked in row[0] for row in ROWS)
