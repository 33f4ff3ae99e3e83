"""docs/input.md says what the readers do: every example in its table is read, and no format is left out."""

import re
from pathlib import Path
from typing import Any

import pytest

from service.formats.points import by_ending, decode
from service.jobs.errors import InvalidInputError

PAGE = (Path(__file__).parents[3] / "docs" / "input.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """Return the cells of the table below a heading, without its head."""
    section = PAGE.split(f"## {heading}\n", 1)[1].split("\n## ", 1)[0]
    table = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


def result(content: bytes, kind: str, options: dict[str, Any]) -> str:
    """Return what the page says when these bytes are read."""
    try:
        found = decode.read(content, kind, 1000, **options)
    except InvalidInputError as error:
        return f"refused: {error}"
    _, normals = decode.split(found.content, found.dimension)
    said = f"{found.points} points in {found.dimension}D"
    said += ", with normals" if normals is not None else ""
    return said + (f", {found.left_out} left out" if found.left_out else "")


EXAMPLES = rows("By example")


@pytest.mark.parametrize(("kind", "content", "options", "says"), EXAMPLES, ids=[str(i) for i in range(len(EXAMPLES))])
def test_each_example_is_read_as_the_page_says(kind: str, content: str, options: str, says: str) -> None:
    text = content.strip("`").replace("⏎", "\n").replace("⇥", "\t")
    given = dict([options.strip("`").split("=", 1)]) if options else {}
    happened = result(text.encode(), kind, given)
    if says.startswith("refused: "):
        assert happened.startswith("refused: ")
        assert says.removeprefix("refused: ") in happened
    else:
        assert happened == says


def test_the_page_lists_every_ending_that_is_read() -> None:
    listed = [ending for _, names, _ in rows("Formats") for ending in re.findall(r"`(\.\w+)`", names)]
    assert sorted(listed) == sorted(by_ending.ENDINGS)


def test_each_way_to_settle_the_columns_has_an_example() -> None:
    kinds = {kind for kind, _, _, _ in EXAMPLES}
    assert kinds == {ending[1:] for ending in by_ending.ENDINGS} - {"npy", "npz", "stl", "glb"}  # which are no text
