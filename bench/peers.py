"""Make bench/PEERS.md, this library beside others on the same points: `python bench/peers.py [SECTION …]`.

Everything in it is made by this run. With the names of sections only those are made, and printed; the page is written
when all are. Each contender runs in a process of its own, on two cores. IPFIT_BENCH_DATA may name the folder of point
sets (see bench/sets.py); without it bent shapes of `ipcore.shapes` and letters stand in. IPFIT_BENCH_OPEN3D may name a
Python that has Open3D, which this project does not install.
"""

import platform
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from contest import agreement, clouds, degrees, meshes, outlines, resources, scale, text, threads, zero_set_grids
from contest.target import Target
from evidence.table import table

HERE = Path(__file__).parent
TOTAL = 780.0  # seconds: a section adds rounds while its share of what is left allows; the first always runs


class Section(NamedTuple):
    """A contest: the function that runs it, its share of the time, its tables as text, and its targets."""

    contest: Callable[[Path, float], Any]
    share: float
    shown: Callable[[Any], str]
    targets: Callable[[Any], list[Target]] = lambda _found: []


SECTIONS = {
    "degrees": Section(degrees.contest, 4.0, degrees.shown, degrees.targets),
    "agreement": Section(agreement.contest, 1.0, agreement.shown, agreement.targets),
    "scale": Section(scale.contest, 3.0, scale.shown, scale.targets),
    "outlines": Section(outlines.contest, 1.0, outlines.shown, outlines.targets),
    "zero_sets": Section(zero_set_grids.contest, 1.0, zero_set_grids.shown, zero_set_grids.targets),
    "meshes": Section(meshes.contest, 1.0, meshes.shown),
    "threads": Section(threads.contest, 1.0, threads.shown),
}


def machine() -> str:
    """Return the machine and the versions of the libraries as text."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
    blas = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "scikit-learn", "scikit-image"))
    return (
        f"{platform.machine()} {model}, {resources.CORES} cores; Python {platform.python_version()}, "
        f"ipfit {version('ipfit')}, {packages}, {blas['name']} {blas['version']}."
    )


def main(requested: list[str]) -> None:
    """Make and print the named sections; without names make all of them and write the page."""
    names, made, aims = requested or list(SECTIONS), {}, []
    end = perf_counter() + TOTAL * sum(SECTIONS[name].share for name in names) / sum(s.share for s in SECTIONS.values())
    for at, name in enumerate(names):
        section, started = SECTIONS[name], perf_counter()
        seconds = (end - started) * section.share / sum(SECTIONS[later].share for later in names[at:])
        with TemporaryDirectory(prefix="ipfit-peers-") as folder:
            found = section.contest(Path(folder), seconds)
        made[name] = f"{text.BEFORE[name]}\n\n{section.shown(found)}"
        aims += [target.cells() for target in section.targets(found)]
        print(f"{name}: {perf_counter() - started:.0f} s", file=sys.stderr)
    goals = f"{text.TARGETS}\n\n{table(['target', 'measured', ''], aims)}"
    if requested:
        print("\n\n".join([*made.values(), goals]))
        return
    source = text.FOLDER if clouds.from_folder() else text.MADE
    page = "\n\n".join([text.TITLE, f"{text.RUN} {source}", machine(), goals, *made.values()])
    (HERE / "PEERS.md").write_text(f"{page}\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
