"""A constant's name has one meaning: no two modules define the same."""

import ast
from collections import defaultdict
from pathlib import Path

from tests.pages import ROOT


def constants(path: Path) -> list[str]:
    """Return the public names in capitals that a module defines at its top."""
    found = []
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        names = [name for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
        found += [name.id for name in names if name.id.isupper() and len(name.id) > 1 and not name.id.startswith("_")]
    return found


def test_no_name_of_a_constant_is_defined_twice() -> None:
    places: dict[str, set[str]] = defaultdict(set)
    for package in ("ipcore", "service"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for name in constants(path):
                places[name].add(str(path.relative_to(ROOT)))
    assert {name: sorted(where) for name, where in places.items() if len(where) > 1} == {}
