"""npy and npz files that nobody means."""

import zipfile
from io import BytesIO
from typing import Any

import numpy as np

from tests.service.bodies import ellipse, npy, sphere
from tests.service.grammars.draws import NAMES, TYPES, Generator, integer

BALL, OUTLINE = sphere(20), ellipse(20)


def npy_header(r: Generator) -> str:
    """Return a Python literal like that of an npy header."""
    fields = [(r.choice(NAMES) or "x", r.choice(TYPES)) for _ in range(r.randrange(5))]
    descr: Any = r.choice([r.choice(TYPES), "<f8", fields, (r.choice(TYPES), (integer(r),)), integer(r)])
    shape: Any = tuple(
        r.choice([integer(r), True, 1.0]) if r.random() < 0.5 else r.choice([2, 3, 20])
        for _ in range(r.choice([0, 1, 2, 2, 2, 3]))
    )
    members = {"descr": descr, "fortran_order": r.choice([True, False, False, 1, None, "no"]), "shape": shape}
    if r.random() < 0.1:
        members.pop(r.choice(list(members)))
    if r.random() < 0.1:
        members["more"] = 1
    text = repr(members)
    if r.random() < 0.1:
        text = r.choice(
            ["(" * r.randrange(3000), text[: r.randrange(len(text))], "{**1}", "[" * 200 + "]" * 200, "-" * 5000 + "1"]
        )
    return text + " " * r.randrange(64) + "\n"


def npy_body(r: Generator) -> bytes:
    if r.random() < 0.3:
        return npy(r.choice([OUTLINE, BALL, BALL[:, :3], np.zeros(20, dtype=[("x", "<f8"), ("y", "<f4")])]))
    text = npy_header(r).encode("latin-1", errors="replace")
    version = r.choice([(1, 0), (1, 0), (2, 0), (3, 0), (0, 0), (255, 255)])
    length = len(text) if r.random() < 0.9 else r.choice([0, 1, 65535, len(text) - 1])
    size = length.to_bytes(2 if version[0] == 1 else 4, "little")
    data = BALL.tobytes()
    return (
        b"\x93NUMPY"
        + bytes(version)
        + size
        + text
        + (data[:320] if r.random() < 0.5 else data[: r.randrange(len(data))])
    )


def npz_body(r: Generator) -> bytes:
    file = BytesIO()
    with zipfile.ZipFile(file, "w", r.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2])) as archive:
        for name in r.sample(["points.npy", "normals.npy", "a.npy", "points", "é", "../x"], r.randrange(4)):
            archive.writestr(name, npy_body(r))
    return file.getvalue()
