"""Clients that three generators write from the OpenAPI document compile, make a fit and take its mesh."""

import json
import shutil
from pathlib import Path

import pytest

from tests.contract.tools import DOCUMENT, HERE, NODE_TOOLS, PYTHON_TOOLS, need_java, need_node, need_python_tools, run

PROGRAMS = HERE / "clients"
EXPECTED = {"status": "successful", "degree": 2, "mesh": "ply", "missing": "/problems/fit-not-found"}
STRICT = ("--strict", "--noUncheckedIndexedAccess", "--exactOptionalPropertyTypes")

# Each takes a while: a JVM, a compiler and a type checker start.
pytestmark = pytest.mark.timeout(600)


def test_openapi_typescript(tmp_path: Path, server: str) -> None:
    node = need_node()
    program = shutil.copy(PROGRAMS / "with_openapi_fetch.ts", tmp_path)
    (tmp_path / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    (tmp_path / "node_modules").symlink_to(HERE / "node_modules")
    # In that folder, else it would lint by the rules of redocly.yaml.
    run(NODE_TOOLS / "openapi-typescript", DOCUMENT, "--output", tmp_path / "ipfit.d.ts", folder=tmp_path)
    options = ("--target", "es2022", "--lib", "es2022,dom", "--module", "nodenext")
    run(NODE_TOOLS / "tsc", *STRICT, *options, program, folder=tmp_path)
    assert json.loads(run(node, "with_openapi_fetch.js", server, folder=tmp_path)) == EXPECTED


def test_openapi_python_client(tmp_path: Path, server: str) -> None:
    need_python_tools()
    made = tmp_path / "client"
    given = ("--path", DOCUMENT, "--config", HERE / "openapi-python-client.yaml", "--output-path", made)
    run(PYTHON_TOOLS / "openapi-python-client", "generate", *given, "--fail-on-warning")
    check_and_use(made, "ipfit_client", "with_openapi_python_client.py", server, "--strict")


def test_openapi_generator(tmp_path: Path, server: str) -> None:
    need_python_tools()
    need_java()
    made = tmp_path / "client"
    run(PYTHON_TOOLS / "openapi-generator-cli", "generate", "-i", DOCUMENT, "-g", "python", "-o", made)
    check_and_use(made, "openapi_client", "with_openapi_generator.py", server)


def check_and_use(made: Path, package: str, program: str, server: str, *strict: str) -> None:
    """Compile a Python client, check its types and those of a program that uses it, and run the program."""
    python = PYTHON_TOOLS / "python"
    run(python, "-W", "error", "-m", "compileall", "-q", made / package)
    cache = ("--config-file=", "--cache-dir", made / ".mypy_cache")
    run(PYTHON_TOOLS / "mypy", *cache, *strict, PROGRAMS / program, made / package, MYPYPATH=str(made))
    assert json.loads(run(python, PROGRAMS / program, server, PYTHONPATH=str(made))) == EXPECTED
