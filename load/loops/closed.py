"""The closed loop: so many clients, each of which sends its next request when the one before is answered (Locust)."""

import os
import pickle
import subprocess
import sys
from pathlib import Path

from load.loops.answers import Answers
from load.loops.traffic import Request

LOCUSTFILE = Path(__file__).with_name("locustfile.py")
# Seconds that the last requests get to end.
PATIENCE = 60


def run(url: str, requests: list[Request], clients: int, seconds: float, folder: Path) -> Answers:
    """Let so many clients send requests for so long, and return the answers."""
    traffic, answers = folder / "traffic.pickle", folder / "answers.txt"
    traffic.write_bytes(pickle.dumps(requests))
    command = [sys.executable, "-m", "locust", "--headless", "--locustfile", str(LOCUSTFILE), "--host", url]
    command += ["--users", str(clients), "--spawn-rate", str(clients), "--run-time", f"{seconds:g}s"]
    command += ["--stop-timeout", str(PATIENCE), "--loglevel", "ERROR", "--only-summary"]
    done = subprocess.run(  # noqa: S603 - our own file in a program of this environment
        command,
        env=os.environ | {"TRAFFIC": str(traffic), "ANSWERS": str(answers)},
        capture_output=True,
        text=True,
        timeout=seconds + 2 * PATIENCE,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"Locust ended with {done.returncode}: {done.stderr[-2000:]}")
    rows = (line.split() for line in answers.read_text(encoding="utf-8").splitlines())
    return Answers.of(((float(at), int(status), float(took)) for at, status, took in rows), seconds)
