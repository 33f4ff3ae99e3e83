"""Compare the fits of two checkouts: `IPFIT_BENCH_DATA=folder python bench/paired.py BEFORE [NAME …]`.

BEFORE is the folder of another checkout. Each set is fitted by it and by this one, in turn, `ROUNDS` times each, every
time in a process of its own, with one thread; the page in `bench/PAIRED.md` has the medians of the processor time.
Without names all closed sets are compared, and the page is written.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

import sets
from evidence.table import table
from quality import MAX_POINTS, usable

HERE = Path(__file__).parent
ROUNDS = 3
SLOW = 20.0  # seconds: sets that take longer are fitted once by each
HEADS = ("set", "degree", "D_dist", "D_smooth", "seconds", "share of the time")
ONE_FIT = """
import json, sys
from time import process_time
import numpy as np
import ipcore
with np.load(sys.argv[1]) as file:
    points, normals = file["points"], file["normals"] if "normals" in file else None
turn = np.linspace(0.0, 6.0, 60)
ipcore.fit(np.column_stack([np.cos(turn), np.sin(turn)]))  # loads what a fit needs
started = process_time()
found = ipcore.fit(points, normals, threads=1)
seconds = process_time() - started
told = found.diagnostics
print(json.dumps([found.degree, told.d_dist, told.d_smooth, told.stray, told.components, seconds]))
"""


@dataclass(frozen=True)
class Fit:
    """A fit as a process told it, with the median of its seconds."""

    degree: int
    d_dist: float
    d_smooth: float
    stray: float | None
    components: int | None
    seconds: float


def fitted(checkout: Path, file: Path) -> Fit:
    """Fit the points of a file with the code of a checkout."""
    told = subprocess.run(  # noqa: S603 - this interpreter, and a program that stands above
        [sys.executable, "-c", ONE_FIT, str(file)],
        env={**os.environ, "PYTHONPATH": str(checkout), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        cwd=checkout,
        capture_output=True,
        text=True,
        check=True,
    )
    return Fit(*json.loads(told.stdout))


def compared(checkouts: tuple[Path, Path], given: sets.PointSet) -> tuple[Fit, Fit]:
    """Return the fits of a set by both checkouts, made in turn."""
    arrays = {"points": given.points} if given.normals is None else {"points": given.points, "normals": given.normals}
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{given.name}.npz"
        np.savez(file, allow_pickle=False, **arrays)
        pairs = [[fitted(checkout, file) for checkout in checkouts]]
        while len(pairs) < ROUNDS and pairs[0][0].seconds < SLOW:
            pairs.append([fitted(checkout, file) for checkout in checkouts])
    before, after = (replace(fits[0], seconds=median(fit.seconds for fit in fits)) for fits in zip(*pairs, strict=True))
    return before, after


def row(name: str, before: Fit, after: Fit) -> list[str]:
    """Return a row of the table."""
    return [
        name,
        f"{before.degree} → {after.degree}",
        f"{before.d_dist:.4f} → {after.d_dist:.4f}",
        f"{before.d_smooth:.3f} → {after.d_smooth:.3f}",
        f"{before.seconds:.2f} → {after.seconds:.2f}",
        f"{after.seconds / before.seconds:.2f}",
    ]


def main() -> None:
    """Compare and print; write the page unless only some sets were asked for."""
    other, *names = sys.argv[1:]
    checkouts = Path(other).resolve(), HERE.parent
    chosen = names or [str(entry["name"]) for entry in sets.index() if entry["closed"]]
    found: dict[str, tuple[Fit, Fit]] = {}
    shown = [usable(sets.load(name).sample(MAX_POINTS)) for name in chosen]
    for one in shown:
        found[one.name] = compared(checkouts, one)
        print(" | ".join(row(one.name, *found[one.name])), flush=True)
    lines = list(summary(shown, found))
    print("\n".join(lines))
    if not names:
        head = f"# Fits of commit {commit(checkouts[0])} and of this one\n\nMade by `python bench/paired.py`."
        body = table(HEADS, (row(name, *pair) for name, pair in found.items()))
        (HERE / "PAIRED.md").write_text("\n\n".join([head, "\n".join(lines), body]) + "\n", encoding="utf-8")


def summary(shown: list[sets.PointSet], found: dict[str, tuple[Fit, Fit]]) -> Iterator[str]:
    """Yield a line about outlines and one about surfaces."""
    for dimension, kind in ((2, "outlines"), (3, "surfaces")):
        pairs = [found[one.name] for one in shown if one.dimension == dimension]
        shares = [after.seconds / before.seconds for before, after in pairs]
        if shares:
            yield f"- {len(shares)} {kind}: median share of the time {median(shares):.2f}, largest {max(shares):.2f}"


def commit(checkout: Path) -> str:
    """Return the short name of the commit that is checked out in a folder."""
    asked = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(asked, cwd=checkout, capture_output=True, text=True, check=True).stdout.strip()  # noqa: S603 - as it stands above


if __name__ == "__main__":
    main()
