"""The open loop: requests arrive at a constant mean rate, whether or not those before are answered (Tsung).

Each request comes on a connection of its own; the times between them are exponentially distributed (a Poisson process).
So a server that falls behind is asked no less, and waits are measured in full.
"""

import os
import re
import shutil
import subprocess
import time
from pathlib import Path
from xml.etree import ElementTree as ET

from load.loops.answers import Answers
from load.loops.traffic import NPY, Request

TSUNG = shutil.which("tsung")
# Columns of Tsung's dump: when a request was answered, its status, and the milliseconds that it took.
AT, STATUS, TOOK = 0, 6, 8
# How many requests were sent so far: each is a user of its own.
USERS = re.compile(r"^stats: users_count \d+ (\d+)$", re.MULTILINE)
DOCTYPE = '<?xml version="1.0"?>\n<!DOCTYPE tsung SYSTEM "/usr/share/tsung/tsung-1.0.dtd">\n'
# Seconds after the last arrival in which requests may still be answered.
PATIENCE = 60
# Seconds that each user stays after its answer. Tsung ends with its last user, and does not write down the answers of
# its last second.
LINGERING = 3


def run(url: str, requests: list[Request], rate: float, seconds: float, folder: Path) -> Answers:
    """Let requests arrive at this rate for so long, and return the answers."""
    plan, log = folder / "tsung.xml", folder / "tsung"
    plan.write_text(DOCTYPE + ET.tostring(_plan(url, requests, rate, seconds, folder), "unicode"), encoding="utf-8")
    log.mkdir()
    began = time.monotonic()
    # the id tells it from another that runs at the same time
    done = subprocess.run(  # noqa: S603 - a program that the system has
        [TSUNG or "tsung", "-f", plan, "-l", f"{log}/", "-n", "-i", str(os.getpid()), "start"],
        capture_output=True,
        text=True,
        timeout=seconds + 2 * PATIENCE,
        check=False,
    )
    found = list(log.rglob("tsung.dump"))
    if done.returncode or not found:
        raise RuntimeError(f"Tsung ended with {done.returncode} after {time.monotonic() - began:.0f} s: {done.stdout}")
    rows = [line.split(";") for line in found[0].read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    answers = [(float(row[AT]), int(row[STATUS] or 0), float(row[TOOK]) / 1000.0) for row in rows]
    sent = USERS.findall(found[0].with_name("tsung.log").read_text(encoding="utf-8"))
    unanswered = max(int(sent[-1]) - len(answers), 0) if sent else 0
    return Answers.of(answers + [(answers[-1][0], 0, 0.0)] * unanswered, seconds)


def _plan(url: str, requests: list[Request], rate: float, seconds: float, folder: Path) -> ET.Element:
    """Return Tsung's configuration: this machine, the server, the rate, and a session for each request."""
    host, _, port = url.removeprefix("http://").partition(":")
    root = ET.Element("tsung", loglevel="warning", dumptraffic="protocol", version="1.0")
    ET.SubElement(
        ET.SubElement(root, "clients"), "client", host="localhost", use_controller_vm="true", maxusers="20000"
    )
    ET.SubElement(ET.SubElement(root, "servers"), "server", host=host, port=port, type="tcp")
    load = ET.SubElement(root, "load", duration=f"{seconds + PATIENCE:.0f}", unit="second")
    phase = ET.SubElement(load, "arrivalphase", phase="1", duration=f"{seconds:.0f}", unit="second")
    ET.SubElement(phase, "users", arrivalrate=f"{60.0 * rate:.0f}", unit="minute")
    sessions = ET.SubElement(root, "sessions")
    total = sum(one.share for one in requests)
    for number, one in enumerate(requests):
        share = f"{100.0 * one.share / total:.4f}"
        session = ET.SubElement(sessions, "session", name=str(number), probability=share, type="ts_http")
        session.append(_request(one, folder / f"body-{number}.npy"))
        ET.SubElement(session, "thinktime", value=f"{LINGERING}", random="false")
    return root


def _request(one: Request, body: Path) -> ET.Element:
    request = ET.Element("request")
    told = {"url": one.path, "method": one.method, "version": "1.1"}
    if one.body:
        body.write_bytes(one.body)
        told |= {"contents_from_file": str(body), "content_type": NPY}
    ET.SubElement(request, "http", told)
    return request
