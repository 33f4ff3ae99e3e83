"""Make bench/PAPER.md, the paper's evidence on real data: `IPFIT_BENCH_DATA=folder python bench/paper.py [SECTION …]`.

The run makes all tables and figures; the comments on them are in evidence/text.py. With names of sections, only those
are made and printed; without, all are made and the page is written.
"""

import os
import platform
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from time import perf_counter

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy is loaded: one thread, as in a worker

from matplotlib.figure import Figure

from evidence import adaptive, cost, families, growth, instability, noise, text

HERE = Path(__file__).parent
PICTURES = HERE / "paper"


def save(figure: Figure, name: str) -> str:
    """Write a figure and return the Markdown that shows it."""
    PICTURES.mkdir(exist_ok=True)
    figure.savefig(PICTURES / f"{name}.png", dpi=110)
    return f"![{name}](paper/{name}.png)"


def shown_growth() -> Iterator[str]:
    yield save(growth.figure(), "growth")
    yield growth.rows()


def shown_adaptive() -> Iterator[str]:
    studied = adaptive.Adaptive()
    yield save(studied.figure(), "adaptive")
    yield studied.rows()


def shown_families() -> Iterator[str]:
    yield save(families.figure(), "families")
    yield families.marks()
    yield families.comparison()


def shown_instability() -> Iterator[str]:
    yield save(instability.figure(), "instability")
    yield instability.rows()


def shown_noise() -> Iterator[str]:
    studied = noise.Noise()
    yield save(studied.figure(), "noise")
    yield studied.rows()


def shown_cost() -> Iterator[str]:
    yield cost.rows()


SECTIONS: dict[str, Callable[[], Iterator[str]]] = {
    "growth": shown_growth,
    "adaptive": shown_adaptive,
    "families": shown_families,
    "instability": shown_instability,
    "cost": shown_cost,
    "noise": shown_noise,
}


def main(requested: list[str]) -> None:
    """Make and print the named sections; without names make all of them and write the page."""
    made = {}
    for name in requested or SECTIONS:
        started = perf_counter()
        made[name] = "\n\n".join([text.BEFORE[name], *SECTIONS[name](), text.AFTER[name]])
        print(f"{name}: {perf_counter() - started:.0f} s", file=sys.stderr)
    if requested:
        print("\n\n".join(made.values()))
        return
    engine = (
        f"Made by ipfit {version('ipfit')}, Python {platform.python_version()}, numpy {version('numpy')}, one thread."
    )
    (HERE / "PAPER.md").write_text("\n\n".join([text.TITLE, engine, *made.values()]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
