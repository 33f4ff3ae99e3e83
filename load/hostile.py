"""Measure what a client that does nothing wrong notices of others that flood, stall or leave.

From the repository's root, with the environment of `make check`:

    python -m load.hostile

Each attacker meets a server of its own, on a free port, with two workers. First the client is alone with it, then the
attacker comes. All traffic stays on this machine. The table is printed as Markdown; load/HOSTILE.md has the last one.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from load.attackers import ATTACKS, MESH_ATTACKS
from tests.service.bodies import npy, torus
from tests.service.running import Server

ALONE_SECONDS, ATTACK_SECONDS = 3.0, 7.0
START_SECONDS = 1.0  # from the start of the attack to that of the measurement
SERVER_SETTINGS: dict[str, object] = {"WORKERS": 2, "SHORT_WORKERS": 1}
LIVEZ_LIMIT, RATIO_LIMIT = 0.1, 3.0
COLUMNS = [
    "attacker", "`/livez` alone: p50, p99", "beside: p50, p99", "small fit alone", "beside", "ratio", "not answered",
    "answers to the attacker", "server's memory",
]  # fmt: skip


@dataclass(frozen=True)
class Row:
    """What was measured of one attacker: the client alone and beside it, its answers, and the server's memory."""

    name: str
    alone: dict[str, Any]
    beside: dict[str, Any]
    answers: dict[str, int]
    before: float
    peak: float

    @property
    def ratio(self) -> float:
        """Return how many times longer a small fit takes beside the attacker."""
        return _median(self.beside["fits"]) / _median(self.alone["fits"])

    @property
    def is_kept(self) -> bool:
        """Return whether the client noticed as little as is promised."""
        return _percentile(self.beside["livez"], 99) <= LIVEZ_LIMIT and self.ratio <= RATIO_LIMIT

    def __str__(self) -> str:
        """Return the row of the table."""
        cells = [self.name]
        cells += [
            f"{_ms(_percentile(one['livez'], 50))}, {_ms(_percentile(one['livez'], 99))} ms"
            for one in (self.alone, self.beside)
        ]
        cells += [f"{_ms(_median(one['fits']))} ms" for one in (self.alone, self.beside)]
        cells += [f"{self.ratio:.1f}", _counted(self.beside["refused"]) or "none", _listed(self.answers) or "none"]
        return f"| {' | '.join([*cells, f'{self.before:.0f} → {self.peak:.0f} MB'])} |"


def main() -> int:
    """Run the attackers and print the table; return 0 if every row is within the limits, else 1."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("attackers", nargs="*", help="beginnings of names; all, if none are given")
    arguments = parser.parse_args()
    names = [*ATTACKS, *MESH_ATTACKS]
    wanted = [name for name in names if not arguments.attackers or name.startswith(tuple(arguments.attackers))]
    print(f"| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}", flush=True)
    rows = []
    for name in wanted:
        rows.append(row(name))
        print(rows[-1], flush=True)
    over = [one.name for one in rows if not one.is_kept]
    print(f"\nOver a limit: {', '.join(over) or 'none'}")
    return 1 if over else 0


def row(name: str) -> Row:
    """Measure one attacker."""
    with tempfile.TemporaryDirectory(prefix="ipfit-hostile-") as folder:
        server = Server(Path(folder) / "data", **SERVER_SETTINGS)
        try:
            port = server.url.rpartition(":")[2]
            fit = server.fit(npy(torus()), "max_degree=4")["id"]
            alone, before = _run("load.victim", port, str(ALONE_SECONDS)), _peak(server.process.pid)
            attack = _start("load.attackers", name, port, str(ATTACK_SECONDS), fit)
            time.sleep(START_SECONDS)
            beside = _run("load.victim", port, str(ATTACK_SECONDS - START_SECONDS - 0.5))
            answers = json.loads(attack.communicate(timeout=60.0)[0])
            return Row(name, alone, beside, answers, before, _peak(server.process.pid))
        finally:
            server.kill()


def _start(module: str, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", module, *arguments], stdout=subprocess.PIPE)  # noqa: S603 - our own


def _run(module: str, *arguments: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(_start(module, *arguments).communicate()[0])
    return found


def _peak(pid: int) -> float:
    """Return the most memory that a process had so far, in MB."""
    status = (Path("/proc") / str(pid) / "status").read_text(encoding="utf-8")
    return int(status.partition("VmHWM:")[2].split()[0]) / 1024.0


def _percentile(seconds: list[float], percent: int) -> float:
    return statistics.quantiles(seconds, n=100)[percent - 1] if len(seconds) > 1 else float("inf")


def _median(seconds: list[float]) -> float:
    return statistics.median(seconds) if seconds else float("inf")


def _ms(seconds: float) -> str:
    return f"{1000.0 * seconds:.0f}"


def _counted(names: list[str]) -> str:
    return _listed({name: names.count(name) for name in names})


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} × {name}" for name, count in sorted(counts.items(), key=lambda one: -one[1]))


if __name__ == "__main__":
    sys.exit(main())
