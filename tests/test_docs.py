"""The pages of docs/: their examples run, their tables are what the program says, their links lead somewhere."""

import json
import re
import subprocess
import sys
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import grimp
import numpy as np
import pytest
from skimage import data, measure

from ipcore import shapes
from service.api.problems import TABLE
from service.formats.points.by_ending import ENDINGS
from service.jobs import errors
from service.problem_types import PROBLEM_TYPES
from tests.pages import BLOCK, DOCS, README, ROOT, RUN_BY, blocks, code, rows, run_examples, skip_without_programs

PAGES = sorted(DOCS.glob("*.md"))
LINKING = [*PAGES, README, *(ROOT / name for name in ("CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"))]
LINKING += sorted([*(ROOT / "bench").glob("*.md"), *(ROOT / "load").glob("*.md")])
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
TABLE_BETWEEN = re.compile(r"<!-- table.*?-->\n(.*?)\n<!-- /table -->", re.DOTALL)
IPFIT = Path(sys.executable).parent / "ipfit"
HORSE_STEP = 3  # as in the README


def openapi() -> dict[str, Any]:
    document: dict[str, Any] = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))
    return document


@cache
def printed(*arguments: str) -> str:
    done = subprocess.run([IPFIT, *arguments], capture_output=True, text=True, timeout=60, check=True)  # noqa: S603 - ours
    return done.stdout


# The examples of extending.md are changes of the code: tests/test_contributing.py makes them.
RUN = [page for page in PAGES if blocks(page, *RUN_BY) and page.name != "extending.md"]


@pytest.mark.parametrize("page", RUN, ids=lambda page: page.name)
@pytest.mark.timeout(300)
def test_every_example_works_as_written(page: Path, server: str, tmp_path: Path) -> None:
    skip_without_programs()
    contour = max(measure.find_contours(data.horse().astype(float), 0.5), key=len)
    np.save(tmp_path / "horse.npy", contour[::HORSE_STEP, ::-1] * np.array([1.0, -1.0]))
    np.save(tmp_path / "torus.npy", np.hstack(shapes.torus().sample(2000)))
    told = run_examples(page, server, tmp_path)
    for expected in {
        "http.md": ["successful 4 criterion-met", "/options/max_degree", "genuine: True, too old: True"],
        "library.md": ["[ True False]"],
    }.get(page.name, []):
        assert expected in told


@pytest.mark.parametrize("name", ["options", "problems", "settings"])
def test_the_tables_are_those_that_the_commands_print(name: str) -> None:
    (table,) = TABLE_BETWEEN.findall((DOCS / f"{name}.md").read_text(encoding="utf-8"))
    assert table == printed(name).strip(), "make docs writes the table anew"


@pytest.mark.parametrize("page", LINKING, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_relative_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(BLOCK.sub("", page.read_text(encoding="utf-8"))):
        if link.startswith(("http://", "https://")):
            continue
        path, _, fragment = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name} links to {link}"
        if fragment:
            assert fragment in anchors(target), f"{page.name} links to {link}"


def anchors(page: Path) -> set[str]:
    """Return the names that a forge gives to the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", BLOCK.sub("", page.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


def test_the_routes_are_those_of_the_contract() -> None:
    listed = {code(route)[0] for route, _ in rows(DOCS / "http.md", "| route |")}
    there = openapi()["paths"].items()
    assert listed == {f"{method.upper()} {path}" for path, methods in there for method in methods}


def test_the_formats_are_those_of_the_contract() -> None:
    listed = rows(DOCS / "http.md", "| `format` |")
    route = openapi()["paths"]["/v1/fits/{fit_id}/mesh"]["get"]
    (parameter,) = [one for one in route["parameters"] if one["name"] == "format"]
    names = next(kind["enum"] for kind in parameter["schema"]["anyOf"] if "enum" in kind)
    assert {code(name)[0] for name, _, _ in listed} == set(names)
    assert {name for _, kinds, _ in listed for name in code(kinds)} == set(route["responses"]["200"]["content"])


def test_every_error_of_the_use_cases_has_a_type_of_problem() -> None:
    assert {kind for _, kind in TABLE} <= PROBLEM_TYPES.keys()
    kinds = {one for one in vars(errors).values() if isinstance(one, type) and issubclass(one, errors.JobError)}
    assert kinds - {errors.JobError} == {kind for kind, _ in TABLE}


def test_the_members_of_a_fit_are_those_of_the_contract() -> None:
    listed = {name for members, *_ in rows(DOCS / "http.md", "| member |") for name in code(members)}
    assert listed == set(openapi()["components"]["schemas"]["FitResource"]["properties"])


def test_the_commands_are_those_of_the_program() -> None:
    listed = [code(command)[0] for command, _ in rows(DOCS / "command-line.md", "| command |")]
    shown = re.findall(r"^[│|] (\w+)  ", printed("--help").partition("Commands")[2], re.MULTILINE)
    assert sorted(listed) == sorted(shown)
    own = [code(option)[0] for option, _ in rows(DOCS / "command-line.md", "| option |")]
    assert all(option in printed("fit", "--help") for option in own)


def test_the_endings_are_those_that_are_read() -> None:
    listed = [ending for cell, _ in rows(DOCS / "command-line.md", "| ending |") for ending in cell.split(", ")]
    assert sorted(listed) == sorted(ENDINGS)


def test_every_setting_that_a_page_names_exists() -> None:
    known = printed("settings")
    for page in (*PAGES, README):
        for name in set(re.findall(r"\bIPFIT_(?!BENCH)[A-Z_0-9]+", page.read_text(encoding="utf-8"))):
            assert f"`{name}`" in known, f"{page.name} names {name}"


def test_every_page_is_in_the_index() -> None:
    linked = set(LINK.findall((DOCS / "README.md").read_text(encoding="utf-8")))
    assert {page.name for page in PAGES} - {"README.md"} <= linked


@pytest.mark.parametrize(("package", "number"), [("ipcore", 0), ("service", 1)])
def test_the_map_has_the_rooms_and_their_imports(package: str, number: int) -> None:
    drawing = blocks(DOCS / "mathematics.md", "mermaid")[number][1]
    drawn = set(re.findall(r"^ +(\w+)\[", drawing, re.MULTILINE))
    arrows = set(re.findall(r"^ +(\w+) --> (\w+)$", drawing, re.MULTILINE))
    graph = grimp.build_graph("ipcore", "service", cache_dir=None)
    rooms = {name.rpartition(".")[2] for name in graph.find_children(package)}
    assert drawn == rooms
    imports = {
        (above, below)
        for above, below in product(rooms, rooms)
        if above != below
        and graph.direct_import_exists(importer=f"{package}.{above}", imported=f"{package}.{below}", as_packages=True)
    }
    assert arrows <= imports, "every arrow is an import"
    assert imports <= implied(arrows), "every import follows from the arrows"


def implied(arrows: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Return all pairs that a way along the arrows connects."""
    found: set[tuple[str, str]] = set()
    more = arrows
    while more - found:
        found |= more
        more = {(a, d) for a, b in found for c, d in arrows if b == c}
    return found


def test_no_page_needs_a_program_to_be_read() -> None:
    """Drawings are text or pictures in the repository; nothing is loaded from elsewhere."""
    for page in (*PAGES, README):
        assert not re.findall(r"!\[[^\]]*\]\((?:https?:)?//", page.read_text(encoding="utf-8"))
    assert (DOCS / "horse.svg").stat().st_size < 60_000
