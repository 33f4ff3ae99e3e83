"""Measure the service under load: closed loops (Locust) and open ones (Tsung), scenario by scenario.

From the repository's root, with the environment of `make load`:

    python -m load.loops embedded cluster --seconds 30
    python -m load.loops embedded --soak 1800

Each scenario meets an engine of its own, with two workers, on this machine, which the clients share. Rows are printed
as Markdown; load/LOAD.md has the last ones. Without Tsung the open loops are skipped, and that is said. The exit status
is 1 if any request got an answer that is none of 200, 202, 429 and 503.
"""

import argparse
import sys

from load.engines import ENGINES
from load.loops import open_loop
from load.loops.measuring import COLUMNS, Row, capacity_of, measure
from load.loops.scenarios import CLOSED_MIXED, SCENARIOS, SOAK, Scenario

CAPACITY_SECONDS = 20.0  # of the closed loop before a soak


def main() -> int:
    """Measure the engines that are asked for, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engines", nargs="*", metavar="ENGINE", help=f"both, or one of: {', '.join(ENGINES)}")
    parser.add_argument("--seconds", type=float, default=30.0, help="of each scenario")
    parser.add_argument("--only", nargs="+", default=[""], metavar="NAME", help="scenarios whose names begin so")
    parser.add_argument("--soak", type=float, default=0.0, metavar="SECONDS", help="only one open loop, for so long")
    arguments = parser.parse_args()
    if unknown := set(arguments.engines).difference(ENGINES):
        parser.error(f"no engine: {', '.join(sorted(unknown))}")
    plan = [(one, arguments.seconds) for one in SCENARIOS if one.name.startswith(tuple(arguments.only))]
    if not plan or plan[0][0].load:
        parser.error("the first scenario has to be a closed loop: " + ", ".join(one.name for one in SCENARIOS))
    if arguments.soak:
        plan = [(CLOSED_MIXED, CAPACITY_SECONDS), (SOAK, arguments.soak)]
    return max([table(engine, plan) for engine in arguments.engines or ENGINES])


def table(engine: str, plan: list[tuple[Scenario, float]]) -> int:
    """Print the table of an engine, and return 1 if there were unexpected answers, else 0."""
    print(f"\n## {engine}\n\n| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}", flush=True)
    rows: list[Row] = []
    for scenario, seconds in plan:
        if scenario.load and open_loop.TSUNG is None:
            print(f"| {scenario.name} | skipped: there is no Tsung (Debian's package tsung) |", flush=True)
            continue
        rows.append(measure(engine, scenario, seconds, capacity_of(scenario.traffic, rows)))
        print(rows[-1], flush=True)
    if rows[-1].scenario is SOAK:
        print(f"\n{rows[-1].slope()}")
    wrong = {row.scenario.name: row.answers.unexpected() for row in rows if row.answers.unexpected()}
    print(f"\nUnexpected answers: {wrong or 'none'}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
