"""Zero sets of degree 12 on fine grids: by ipfit, and by scikit-image after evaluation at every node."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from skimage.measure import marching_cubes

import ipcore
from contest.process import ContenderRef, run_alone
from contest.rounds import Scores, interleaved, rounds_as_text, seconds_of
from contest.target import Target, at_most
from contest.trial import Contender, Trial
from evidence.table import table
from sets import FloatArray
from zero_sets import bumpy

GOALS = {256: 1.0, 512: 3.0}  # seconds
COARSE = 32  # the grid of the warm-up
OURS, THEIRS = "ipfit", "every node, scikit-image"

Surface = tuple[FloatArray, Any]  # vertices (V, 3) and triangles (T, 3)


def ours(polynomial: ipcore.ImplicitPolynomial, data: FloatArray, lines: int) -> Surface:
    """Return the zero set by ipfit, which also measures its stray share against data."""
    found = ipcore.zero_set(polynomial, resolution=lines, data=data)
    return found.vertices, found.cells


def theirs(polynomial: ipcore.ImplicitPolynomial, data: FloatArray, lines: int) -> Surface:  # noqa: ARG001 - has no use for them
    """Return the zero set by scikit-image's marching cubes."""
    low, high = polynomial.bounds
    axes = [np.linspace(a, b, lines) for a, b in zip(low, high, strict=True)]
    vertices, faces, *_ = marching_cubes(polynomial.on_grid(axes), 0.0, spacing=tuple((high - low) / (lines - 1)))
    return vertices + low, faces


def _ready(lines: int, way: str, folder: Path) -> Trial:  # noqa: ARG001 - the surface is a formula
    polynomial, work = bumpy(3), {OURS: ours, THEIRS: theirs}[way]
    data = ipcore.zero_set(polynomial, resolution=60, cap=False).vertices

    def judged(found: Surface) -> dict[str, Any]:
        vertices, faces = found
        off = float(np.abs(polynomial.distance(vertices[:: 1 + len(vertices) // 10_000])).max())
        return {"vertices": len(vertices), "cells": len(faces), "off": off}

    return Trial(lambda: work(polynomial, data, COARSE), lambda: work(polynomial, data, lines), judged)


CONTENDERS: dict[str, Contender] = {
    f"{lines}³, {way}": partial(_ready, lines, way) for lines in GOALS for way in (OURS, THEIRS)
}


def contest(folder: Path, seconds: float) -> Scores:
    """Run all contenders in turn."""
    return interleaved(list(CONTENDERS), lambda name: run_alone(ContenderRef("zero_set_grids", name, folder)), seconds)


def targets(scores: Scores) -> list[Target]:
    """Return the targets of the times."""
    return [
        at_most(f"zero set of degree 12 at {lines}³", seconds_of(scores, f"{lines}³, {OURS}"), limit, " s")
        for lines, limit in GOALS.items()
    ]


def shown(scores: Scores) -> str:
    """Return the table."""
    lines = []
    for name, one in scores.items():
        if one.failed:
            lines.append([name, one.failed, *[""] * 5])
            continue
        cells = [f"{one.seconds:.2f}", f"{one.cpu:.2f}", f"{one.above:.0f}"]
        lines.append([name, *cells, f"{one.found['vertices']:,}", f"{one.found['off']:.0e}"])
    heads = ["zero set", "s", "CPU s", "peak MB", "vertices", "farthest vertex from f = 0"]
    return f"{rounds_as_text(scores)}.\n\n{table(heads, lines)}"
