"""Submits fits while every kind of process is killed at random, then checks every promise that was made.

From the repository's root, with the environment of `make check`:

    python -m load.chaos embedded --fits 1000 --kills 200
    python -m load.chaos cluster --fits 1000 --kills 200

The summary is printed as Markdown; load/CHAOS.md keeps those of the last runs.
"""

import argparse
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path
from threading import Event, Thread

from load import verdict
from load.clients import FITS, Caller, Log
from load.fleet import Fleet

CALLERS = 8


def main() -> int:
    """Run and judge; return 0 if every promise was kept."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=("embedded", "cluster"))
    parser.add_argument("--fits", type=int, default=1000, help="accepted fits, at least")
    parser.add_argument("--kills", type=int, default=200, help="SIGKILLs, at least")
    parser.add_argument("--pause", type=float, default=1.2, help="mean seconds between two strikes")
    parser.add_argument("--seed", type=int, default=1)
    told = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="ipfit-chaos-"))
    folder.chmod(0o755)
    fleet, log = Fleet(folder, cluster=told.engine == "cluster"), Log()
    try:
        kept = _run(fleet, log, told)
    finally:
        fleet.end()
    if kept:
        shutil.rmtree(folder)
    else:
        sys.stderr.write(f"the logs and the store are in {folder}\n")
    return 0 if kept else 1


def _run(fleet: Fleet, log: Log, told: argparse.Namespace) -> bool:
    fleet.start()
    for port in fleet.ports:
        one = Caller(CALLERS, [port], Log(), told.seed)
        while (answer := one.ask("GET", "/readyz")) is None or not answer.is_success:
            time.sleep(0.2)
    asker = Caller(CALLERS, fleet.ports, Log(), told.seed)
    reference = verdict.in_peace(asker.ask, [(content, query) for content, query, _ in FITS])
    verdict.install_audit(fleet)
    began, enough = time.monotonic(), Event()
    callers = [
        Thread(target=Caller(i, fleet.ports, log, told.seed).work, args=(enough,), name=f"caller {i}")
        for i in range(CALLERS)
    ]
    for caller in callers:
        caller.start()
    chance = random.Random(told.seed)  # noqa: S311 - no secret
    while len(log.promises) < told.fits or fleet.kills.total() < told.kills:
        if log.silent() > verdict.QUIET:
            log.unexplained.append(f"nothing was accepted any more for {verdict.QUIET:g} s")
            break
        time.sleep(chance.expovariate(1.0 / told.pause))
        if fleet.kills.total() * told.fits <= told.kills * len(log.promises):  # from the first fit to the last
            fleet.strike(chance)
    enough.set()
    for caller in callers:
        caller.join()
    struck = time.monotonic() - began
    result = verdict.Verdict(fleet, log, reference)
    result.reach()
    return _tell(fleet, log, result, told, struck, time.monotonic() - began)


def _tell(  # noqa: PLR0913, PLR0917 - what there is to tell
    fleet: Fleet, log: Log, result: verdict.Verdict, told: argparse.Namespace, struck: float, took: float
) -> bool:
    """Print the summary; return whether every promise was kept."""
    faults = {
        "lost": result.lost,
        "finished twice": result.twice,
        "stuck": result.stuck,
        "wrong": result.wrong,
        "unexplained errors": log.unexplained,
    }
    print(f"## {told.engine}, seed {told.seed}\n")
    print(f"- accepted fits: {len(log.promises)}; how they ended: {_listed(result.ends)}")
    print(f"- parts of fits: {_listed(result.parts)}")
    print(f"- SIGKILLs: {fleet.kills.total()}; {_listed(fleet.kills)}; besides: {_listed(fleet.other) or 'nothing'}")
    print(f"- programs started: {sum(one.starts for one in fleet.servers + fleet.hands)}")
    print(f"- answers: {_listed(log.answers)}")
    print(f"- {struck:.0f} s under fire, {took - struck:.0f} s until the last fit had ended and was looked at")
    print(f"- **{', '.join(f'{len(found)} {name}' for name, found in faults.items())}**\n")
    for name, found in faults.items():
        for one in found[:10]:
            print(f"{name}: {one}")
    return not any(faults.values())


def _listed(counts: "dict[str, int]") -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items(), key=lambda one: -one[1]))


if __name__ == "__main__":
    sys.exit(main())
