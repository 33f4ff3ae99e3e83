"""Integers, names and types as nobody means them, drawn at random."""

import random
from typing import Any

Generator = random.Random
INTEGERS = [0, 1, 2, 3, 4, 6, 20, -1, -20, 255, 2**31, 2**62, 2**63, 2**64, 10**18, 10**40]
TYPES = [
    "<f8",
    ">f8",
    "<f4",
    "<f2",
    "|u1",
    "<i8",
    ">u2",
    "|b1",
    "<c16",
    "<U3",
    "|S4",
    "|O",
    "<M8[s]",
    "<f16",
    "f8",
    "|V0",
    "",
]
NAMES = [
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "X",
    "Y",
    "normal_x",
    "red",
    "",
    "_",
    "0",
    "1",
    "é",
    "x [mm]",
    '"x"',
    "Points:0",
]


def integer(r: Generator) -> int:
    return r.choice(INTEGERS) if r.random() < 0.7 else r.randrange(-5, 50)


def scalar(r: Generator) -> Any:  # noqa: ANN401 - JSON
    return r.choice(
        [integer(r), r.uniform(-9, 9), r.gauss(0, 1) * 10 ** r.randrange(-300, 300), None, True, "1", "", [], {}, [[1]]]
    )
