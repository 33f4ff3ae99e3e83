"""The documentation page in a browser that can reach this server only."""

import re
import shutil
import subprocess
from pathlib import Path

import httpx
import pytest

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
    "--virtual-time-budget=15000",
]


def test_the_page_names_no_other_host(client: httpx.Client) -> None:
    page = client.get("/docs")
    assert page.headers["Content-Type"].startswith("text/html")
    assert not re.findall(r"https?:|src=\"//|href=\"//", page.text)
    assert '"validatorUrl": null' in page.text
    sources = re.findall(r'(?:src|href)="([^"]+)"', page.text)
    assert len(sources) == 3
    for source in sources:
        assert client.get(source).is_success, source


def test_a_person_who_opens_the_server_is_led_there(client: httpx.Client) -> None:
    answer = client.get("/")
    assert (answer.is_redirect, answer.headers["Location"]) == (True, "/docs")


@pytest.mark.parametrize("path", ["/livez", "/readyz"])
def test_health(client: httpx.Client, path: str) -> None:
    assert client.get(path).json() == {"status": "ok"}


def test_the_operations_show_in_a_browser(server: str, tmp_path: Path) -> None:
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("THE DOCUMENTATION PAGE WAS NOT TESTED IN A BROWSER: there is no chromium or google-chrome here")
    shown = subprocess.run(  # noqa: S603 - a browser
        [browser, *FLAGS, f"--user-data-dir={tmp_path}", "--dump-dom", f"{server}/docs"],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=True,
    ).stdout
    for words in (
        "Fit a point set",
        "Look at a fit",
        "Take the zero set",
        "Dismiss or remove a fit",
        "negative inside",
    ):
        assert words in shown
    assert "Failed to load API definition" not in shown
