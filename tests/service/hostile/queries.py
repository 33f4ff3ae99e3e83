"""Query strings: options out of range, as the OpenAPI document lists them, and what is no query."""

import json
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

from tests.service.hostile.cases import BODY, POINTS, REFUSED, TAKEN, Case, post

DOCUMENT = Path(__file__).parents[3] / "openapi" / "openapi.json"
# Values that no option takes, and such as look like values.
NO_VALUES = [
    "", "%00", "%FF", "\uff15", "1_0", "1e999", "nan", "[]", "1,2", "x" * 5000, "9" * 5000, "-9223372036854775809",
]  # fmt: skip
# Those of them that are values of some options.
SOME_VALUES = {"1.5", "2", "-1", "1_0"}
NO_NUMBERS = ["true", "None", "1 2", "0x1", "--1", "1e", "٣"]
QUERIES = [
    "?", "&", "&&&&", "=", "==", "=1", "max_degree", "max_degree=", "max_degree==2", "max_degree=2=3",
    "max_degree=2&max_degree=3", "MAX_DEGREE=2", "max_degree[]=2", "max_degree[a]=2", "max%5Fdegree=2",
    "max_degree%00=2", "+max_degree=2", "max_degree+=2", "%", "%zz", "%=1", "\xff", "é=ü", "a=" + "b" * 50_000,
    "a" * 50_000 + "=1", "&".join(f"k{i}=1" for i in range(5000)), "max_degree=2&" * 4000, "max_degree=2;t1=0", "#x",
    "a=1#b", "__proto__=1", "constructor=1", "self=1", "model_config=1", "request=1", "context=1", "query=1",
    "options=1", "points=1", "max_degree=2%26t1=0", "max_degree=%32", "max_degree=2%0a", "max_degree=2%0d%0aX:%20y",
    "preset=paper&factor=moments", "format=npz", "format=npy&format=json", "format=exe", "format=..%2fjson",
    "format=JSON", "format=csv%00", "format=", "geometric=true&constraints=taubin", "signs=maybe",
]  # fmt: skip
WRONG_JSON = ["null", "[]", "{}", '"x"', "1e999", "-1", "true", "1.5", '"\\ud800"', "9" * 30, '"' + "x" * 5000 + '"']


@cache
def options() -> dict[str, dict[str, Any]]:
    """Return the schema of each option of a fit."""
    document = json.loads(DOCUMENT.read_text(encoding="utf-8"))
    found: dict[str, dict[str, Any]] = document["components"]["schemas"]["FitOptions"]["properties"]
    return found


def out_of_range(schema: dict[str, Any]) -> list[str]:
    """Return numbers just below and just above what an option may be."""
    kinds = [schema, *schema.get("anyOf", [])]
    found = []
    for kind in kinds:
        whole = kind.get("type") == "integer"
        step = 1 if whole else 1e-9
        found += [str(kind[name] + sign * step) for name, sign in (("minimum", -1), ("maximum", 1)) if name in kind]
        found += [str(kind["exclusiveMinimum"])] if "exclusiveMinimum" in kind else []
        found += ["1.5", "2.0000001"] if whole else []
        found += NO_NUMBERS if kind.get("type") in {"integer", "number"} else []
        found += (
            [kind["enum"][0].upper() + " ", ",".join(kind["enum"]), kind["enum"][0] + "\x00"] if "enum" in kind else []
        )
        found += ["2", "-1", "yes please", "TRUEE"] if kind.get("type") == "boolean" else []
    return found


def option_values() -> list[Case]:
    """Return every option with every value that it does not take, in the query."""
    found = []
    for name, schema in options().items():
        for value in dict.fromkeys([*NO_VALUES, *out_of_range(schema)]):
            sent = post(query=f"{name}={quote(value, safe='%')}")
            statuses = REFUSED | (TAKEN if value in SOME_VALUES else set())
            found.append(Case(f"{name}={value[:20]!r} ({len(value)})", (sent,), statuses))
    return found


def option_members() -> list[Case]:
    """Return every option with every JSON value that it may not take, in the body."""
    return [
        Case(f"{name}: {value[:20]} ({len(value)})", (post(_body(f'"{name}": {value}')),), REFUSED | TAKEN)
        for name in options()
        for value in WRONG_JSON
    ]


def queries() -> list[Case]:
    """Return query strings that are none, or name things that are no parameters."""
    return [
        Case(f"{q[:40]!r} ({len(q)})", (post(BODY, query=q.encode("latin-1", "replace")),), REFUSED | TAKEN)
        for q in QUERIES
    ]


def _body(option: str) -> bytes:
    return f'{{"points": {json.dumps(POINTS)}, "options": {{{option}}}}}'.encode()
