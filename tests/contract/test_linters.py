"""The OpenAPI document is clean by both linters; the rules that are off are few, and say why."""

import re

import pytest

from tests.contract.tools import DOCUMENT, HERE, NODE_TOOLS, need_node, run


def test_spectral_with_the_rules_of_owasp_finds_nothing() -> None:
    need_node()
    rules = HERE / ".spectral.yaml"
    run(NODE_TOOLS / "spectral", "lint", DOCUMENT, "--ruleset", rules, "--fail-severity", "hint")


def test_redocly_with_its_strict_rules_finds_nothing() -> None:
    need_node()
    run(NODE_TOOLS / "redocly", "lint", DOCUMENT, "--config", HERE / "redocly.yaml")


@pytest.mark.parametrize("name", [".spectral.yaml", "redocly.yaml"])
def test_what_is_off_says_why(name: str) -> None:
    reason = False
    for line in (HERE / name).read_text(encoding="utf-8").splitlines():
        goes_on = re.search(r": off$|rules:$|files:|^ +- \"", line) is not None
        reason = line.lstrip().startswith("#") or (reason and goes_on)
        assert reason or not line.endswith(": off"), line


def test_the_lock_names_no_registry() -> None:
    assert '"resolved"' not in (HERE / "package-lock.json").read_text(encoding="utf-8")
