"""Send fits while processes of every kind are killed at random, then check every promise of the service.

From the repository's root, with the environment of `make check`:

    python -m load.chaos embedded --fits 1000 --kills 200
    python -m load.chaos cluster --fits 1000 --kills 200

The summary is printed as Markdown; load/CHAOS.md has the summaries of the last runs.
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
    """Run, check and print the summary; return 0 if every promise was kept, else 1."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=("embedded", "cluster"))
    parser.add_argument("--fits", type=int, default=1000, help="accepted fits, at least")
    parser.add_argument("--kills", type=int, default=200, help="SIGKILLs, at least")
    parser.add_argument("--pause", type=float, default=1.2, help="mean seconds between two faults")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="ipfit-chaos-"))
    folder.chmod(0o755)
    fleet, log = Fleet(folder, cluster=arguments.engine == "cluster"), Log()
    try:
        kept = _run(fleet, log, arguments)
    finally:
        fleet.end()
    if kept:
        shutil.rmtree(folder)
    else:
        sys.stderr.write(f"the logs and the store are in {folder}\n")
    return 0 if kept else 1


def _run(fleet: Fleet, log: Log, arguments: argparse.Namespace) -> bool:
    fleet.start()
    for port in fleet.ports:
        one = Caller(CALLERS, [port], Log(), arguments.seed)
        while (answer := one.ask("GET", "/readyz")) is None or not answer.is_success:
            time.sleep(0.2)
    asker = Caller(CALLERS, fleet.ports, Log(), arguments.seed)
    reference = verdict.undisturbed(asker.ask, [(content, query) for content, query, _ in FITS])
    verdict.install_audit(fleet)
    began, enough = time.monotonic(), Event()
    callers = [
        Thread(target=Caller(i, fleet.ports, log, arguments.seed).work, args=(enough,), name=f"caller {i}")
        for i in range(CALLERS)
    ]
    for caller in callers:
        caller.start()
    generator = random.Random(arguments.seed)  # noqa: S311 - no secret
    while len(log.promises) < arguments.fits or fleet.kills.total() < arguments.kills:
        if log.silent() > verdict.END_WITHIN:
            log.unexplained.append(f"nothing was accepted any more for {verdict.END_WITHIN:g} s")
            break
        time.sleep(generator.expovariate(1.0 / arguments.pause))
        # in proportion to the accepted fits, so that the kills are spread over all of them
        if fleet.kills.total() * arguments.fits <= arguments.kills * len(log.promises):
            fleet.cause_fault(generator)
    enough.set()
    for caller in callers:
        caller.join()
    with_faults = time.monotonic() - began
    result = verdict.Verdict(fleet, log, reference)
    result.reach()
    return _print_summary(fleet, log, result, arguments, with_faults, time.monotonic() - began)


def _print_summary(  # noqa: PLR0913, PLR0917 - the parts of a summary
    fleet: Fleet, log: Log, result: verdict.Verdict, arguments: argparse.Namespace, with_faults: float, took: float
) -> bool:
    """Print the summary; return whether every promise was kept."""
    faults = {
        "lost": result.lost,
        "finished twice": result.twice,
        "stuck": result.stuck,
        "wrong": result.wrong,
        "unexplained errors": log.unexplained,
    }
    print(f"## {arguments.engine}, seed {arguments.seed}\n")
    print(f"- accepted fits: {len(log.promises)}; how they ended: {_listed(result.ends)}")
    print(f"- parts of fits: {_listed(result.parts)}")
    print(f"- SIGKILLs: {fleet.kills.total()}; {_listed(fleet.kills)}; besides: {_listed(fleet.other) or 'nothing'}")
    print(f"- programs started: {sum(one.starts for one in fleet.servers + fleet.worker_programs)}")
    print(f"- answers: {_listed(log.answers)}")
    print(f"- {with_faults:.0f} s of faults, {took - with_faults:.0f} s until the last fit had ended and was looked at")
    print(f"- **{', '.join(f'{len(found)} {name}' for name, found in faults.items())}**\n")
    for name, found in faults.items():
        for one in found[:10]:
            print(f"{name}: {one}")
    return not any(faults.values())


def _listed(counts: "dict[str, int]") -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items(), key=lambda one: -one[1]))


if __name__ == "__main__":
    sys.exit(main())
