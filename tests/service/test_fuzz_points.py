"""Point sets that nobody means, made by the grammars of the formats: each is read, or refused by a declared error.

A second for each grammar, or IPFIT_FUZZ_SECONDS. A failure names the seed that makes the same input again.
"""

import os
import random
import time
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import orjson
import pytest

from service.formats.points import decode
from service.jobs.errors import JobError
from tests.service.grammars.draws import Generator
from tests.service.grammars.geometry import obj_body, off_body, ply_body
from tests.service.grammars.json_points import json_body
from tests.service.grammars.numpy_files import npy_body, npz_body
from tests.service.grammars.tables import table_body

SECONDS = float(os.environ.get("IPFIT_FUZZ_SECONDS", "1"))
MOST = 300  # points
# Python objects for every byte of the input, and what a library makes for its own use when it is first called.
BYTES_PER_BYTE, BYTES = 400, 20_000_000
GRAMMARS: dict[str, Callable[[Generator], bytes]] = {
    "json": json_body,
    "npy": npy_body,
    "npz": npz_body,
    "csv": table_body,
    "ply": ply_body,
    "obj": obj_body,
    "off": off_body,
}


def damaged(content: bytes, r: Generator) -> bytes:
    """Return the content with some bytes replaced, taken out, put in or doubled."""
    for _ in range(r.choice([0, 0, 0, 0, 0, 1, 2, 8])):
        at, length = r.randrange(len(content) + 1), r.randrange(1, 9)
        put = r.choice([b"", r.randbytes(length), content[at : at + length] * 2, b"\xff", b"\n", b'"'])
        content = content[:at] + put + content[at + r.choice([0, len(put), length]) :]
    return content[: r.randrange(len(content) + 1)] if r.random() < 0.05 else content


def tried(seed: int, kind: str) -> bool:
    """Read the input that this seed makes, and return whether it was a point set."""
    r = random.Random(f"{kind} {seed}")  # noqa: S311 - no secret
    content = damaged(GRAMMARS[kind](r), r)
    columns = (
        None if r.random() < 0.7 else r.choice(["x,y", "x,y,z", "x,y,_,_", "x,y,z,nx,ny,nz", ",", "x,x", "é", "_"])
    )
    missing: Any = r.choice(["refuse", "drop"])
    tracemalloc.reset_peak()
    before = tracemalloc.get_traced_memory()[0]
    try:
        found = decode.read(content, kind, MOST, columns=columns, missing=missing)
    except JobError as error:
        assert len(str(error)) < 500, f"seed {seed}: {error}"  # noqa: PT017 - nothing else may be raised
        orjson.dumps(str(error))  # an answer can be made of it
        orjson.dumps(getattr(error, "at", ()))
        return False
    finally:
        peak = tracemalloc.get_traced_memory()[1] - before
        assert peak < BYTES + BYTES_PER_BYTE * len(content), f"seed {seed}: {peak} bytes"
    x, n = decode.split(found.content, found.dimension)
    assert x.shape == (found.points, found.dimension), f"seed {seed}"
    assert np.isfinite(x).all(), f"seed {seed}"
    assert n is None or np.allclose(np.linalg.norm(n, axis=1), 1.0), f"seed {seed}"
    return True


@pytest.mark.timeout(SECONDS + 300)
@pytest.mark.parametrize("kind", list(GRAMMARS))
def test_no_input_of_the_grammar_breaks_its_reader(kind: str) -> None:
    first = int(os.environ.get("IPFIT_FUZZ_SEED", "0"))
    end, seed, read = time.monotonic() + SECONDS, first, 0
    tracemalloc.start()
    try:
        while time.monotonic() < end or seed < first + 50:
            try:
                read += tried(seed, kind)
            except Exception as error:
                error.add_note(f"IPFIT_FUZZ_SEED={seed} makes this {kind} again")
                raise
            seed += 1
    finally:
        tracemalloc.stop()
    assert read or seed < first + 500  # the grammar makes point sets, too
