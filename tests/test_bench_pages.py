"""The benchmark pages have the text that their scripts write around the numbers."""

from importlib import import_module

import pytest

from tests.pages import ROOT

BENCH = ROOT / "bench"


@pytest.mark.parametrize(("page", "module"), [("PEERS.md", "contest.text"), ("PAPER.md", "evidence.text")])
def test_a_page_has_the_text_of_its_script(page: str, module: str) -> None:
    pytest.importorskip("matplotlib", reason="the scripts of bench need matplotlib: make .venv/.bench-stamp")
    text = import_module(module)
    parts = [getattr(text, name) for name in ("TITLE", "RUN", "TARGETS") if hasattr(text, name)]
    for part in (*parts, *text.BEFORE.values(), *getattr(text, "AFTER", {}).values()):
        assert plain(part) in plain((BENCH / page).read_text(encoding="utf-8"))


def test_the_page_on_quality_ends_with_its_conclusions() -> None:
    conclusions = (BENCH / "quality" / "conclusions.md").read_text(encoding="utf-8").strip()
    assert (BENCH / "QUALITY.md").read_text(encoding="utf-8").strip().endswith(conclusions)


def plain(text: str) -> str:
    return " ".join(text.split())
