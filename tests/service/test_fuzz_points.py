"""Point sets that nobody means, made by the grammars of the formats: each is read, or refused by a declared error.

A second for each grammar, or IPFIT_FUZZ_SECONDS. A failure names the seed that makes the same input again.
"""

import base64
import json
import os
import random
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
import orjson
import pytest

from service.formats.points import decode
from service.jobs.errors import JobError
from tests.service.bodies import ellipse, npy, sphere

SECONDS = float(os.environ.get("IPFIT_FUZZ_SECONDS", "1"))
MOST = 300  # points
# Python objects for every byte of the input, and what a library makes for its own use when it is first called.
BYTES_PER_BYTE, BYTES = 400, 20_000_000

BALL, OUTLINE = sphere(20), ellipse(20)
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
NUMBERS = [
    "0",
    "1",
    "-1",
    "0.5",
    "1e3",
    "1e308",
    "-1e400",
    "5e-324",
    "nan",
    "inf",
    "",
    " ",
    "-",
    "NA",
    "1,5",
    "x",
    "1_0",
    "½",
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


def rows(r: Generator) -> list[list[Any]]:
    """Return some rows; most are numbers, all of one width."""
    width = r.choice([0, 1, 2, 2, 2, 3, 3, 3, 4, 5, 6])
    wild = r.choice([0.0, 0.0, 0.02, 0.5])
    table: list[list[Any]] = [
        [scalar(r) if r.random() < wild else r.uniform(-2, 2) for _ in range(width)]
        for _ in range(r.choice([0, 1, 5, 20, 301]))
    ]
    if table and r.random() < 0.1:
        r.choice(table).append(1.0)
    return table


def packed(r: Generator) -> dict[str, Any]:
    count, width = r.choice([0, 1, 5, 20]), r.choice([0, 1, 2, 3, 4, 6])
    data = (BALL.tobytes() * 2)[: 8 * count * width] if r.random() < 0.8 else r.randbytes(r.randrange(99))
    shape: Any = [count, width] if r.random() < 0.5 else [integer(r) for _ in range(r.choice([0, 1, 2, 2, 2, 3]))]
    if r.random() < 0.2:
        shape = r.choice([None, "20", [True, 2], [20.0, 2], [[20], 2], {}])
    text = base64.b64encode(data).decode()
    array = {
        "dtype": r.choice(TYPES),
        "shape": shape,
        "data": text if r.random() < 0.9 else r.choice([text[1:], "%", 5]),
    }
    if r.random() < 0.1:
        array[r.choice(["order", "dtype"])] = scalar(r)
    return array


def nested(r: Generator) -> Any:  # noqa: ANN401 - JSON
    value: Any = 1
    for _ in range(r.choice([3, 254, 255, 256, 600, 900])):
        value = [value] if r.random() < 0.7 else {"a": value}
    return value


def json_body(r: Generator) -> bytes:
    made = [rows, rows, rows, packed, packed, nested, scalar]
    body: Any = {"points": r.choice(made)(r)}
    if r.random() < 0.4:
        body["normals"] = r.choice(made)(r)
    if r.random() < 0.3:
        body["options"] = r.choice([{"t1": scalar(r)}, {"x": nested(r)}, scalar(r)])
    if r.random() < 0.1:
        body[r.choice(NAMES)] = scalar(r)
    if r.random() < 0.1:
        body = r.choice([[body], body["points"], scalar(r)])
    mark = b"\xef\xbb\xbf" if r.random() < 0.1 else b""
    return mark + json.dumps(body).encode()


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


def table_body(r: Generator) -> bytes:
    delimiter = r.choice([",", ",", ";", "\t", " ", "  ", ", ", "|"])
    width = r.choice([1, 2, 2, 3, 3, 4, 6, 7])
    wild = r.choice([0.0, 0.0, 0.0, 0.01, 0.5])

    def cell() -> str:
        if r.random() < wild:
            return r.choice([*NUMBERS, '"', '"1"', '"a' + delimiter + 'b"', "\x00", "#", "x" * r.randrange(200)])
        return repr(r.uniform(-2, 2)).replace(".", "," if delimiter == ";" else ".")

    before = ["# c", "# c", "", "//X Y Z", "% x" + delimiter + "y", "", "20", "0", "99999999999999999999", "#"]
    lines = [r.choice(before) for _ in range(r.choice([0, 0, 1, 2]))]
    if r.random() < 0.5:
        names = (
            [r.choice(NAMES) for _ in range(width)] if r.random() < 0.5 else ["x", "y", "z", "q", "r", "s", "t"][:width]
        )
        lines.append(delimiter.join(names))
    for i in range(r.choice([0, 1, 5, 20, 20, 301])):
        cells = [cell() for _ in range(width)]
        lines.append(
            delimiter.join(cells if r.random() > wild / 5 else [str(i), *cells])
            + r.choice(["", "", "", delimiter if wild else ""])
        )
        if r.random() < wild / 5:
            lines.append(r.choice(["", "# c", "20", delimiter * 5]))
    text = r.choice(["\n", "\n", "\r\n", "\r"]).join(lines)
    return text.encode(r.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-be"]))


PLY_TYPES = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4", "short": "i2", "uint16": "u2", "int64": "i8"}


def ply_element(r: Generator, name: str, order: str, lines: list[str]) -> bytes:
    """Add the header of an element, and return data that nearly always are as many as it says."""
    count = r.choice([20, 20, 3, 0]) if r.random() < 0.9 else integer(r)
    lines.append(f"element {name} {count}")
    properties = r.choice([["x", "y"], ["x", "y", "z"], ["nx", "x", "ny", "y"], ["q"], r.sample(NAMES, 4)])
    kinds = [r.choice(list(PLY_TYPES)[: r.choice([2, 7])]) for _ in properties]
    lines += [f"property {kind} {one}" for kind, one in zip(kinds, properties, strict=True)]
    length = r.choice([0, 3, 3, 4]) if name == "face" or r.random() < 0.1 else None
    if length is not None:
        lines.append(f"property list uchar {r.choice(['int', 'uchar', 'float', 'int64'])} vertex_indices")
    if r.random() < 0.05:
        wrong = ["comment c", "obj_info", "element", "property", "property float128 x", "property list float int q", ""]
        lines.insert(r.randrange(len(lines)), r.choice(wrong))
    data = b""
    for _ in range(min(max(count, 0), 20)):
        values = [
            r.choice([r.uniform(-2, 2), r.randrange(20)]) if r.random() < 0.98 else r.choice([1e300, 7]) for _ in kinds
        ]
        corners = [] if length is None else [length, *[r.randrange(21) for _ in range(length)]]
        if order == "":
            data += (" ".join(map(repr, [*values, *corners])) + "\n").encode()
        else:
            types = [PLY_TYPES[kind] for kind in kinds]
            with np.errstate(all="ignore"):
                data += b"".join(np.float64(v).astype(order + t).tobytes() for v, t in zip(values, types, strict=True))
            data += bytes(corners[:1]) + np.array(corners[1:], dtype=order + "i4").tobytes()
    return data


def ply_body(r: Generator) -> bytes:
    form, order = r.choice([("ascii", ""), ("binary_little_endian", "<"), ("binary_big_endian", ">")])
    lines = ["ply", f"format {form} 1.0"]
    names = r.choice([["vertex"], ["vertex"], ["vertex", "face"], ["face", "vertex"], ["edge", "vertex", "face"], []])
    data = b"".join(ply_element(r, name, order, lines) for name in names)
    lines += ["end_header"] if r.random() < 0.97 else []
    return (r.choice(["\n", "\n", "\r\n"]).join(lines) + "\n").encode() + data


def obj_body(r: Generator) -> bytes:
    words = ["v", "v", "v", "v", "vn", "f", "f", "vt", "#", "mtllib", "l", "o", "\\"]
    corner = ["1", "2", "-1", "1/1", "1//1", "2//-1", "1/1/1", "0", "9", "1/", "//", "x", "10000000000000000000000"]

    def line() -> str:
        word = r.choice(words)
        values = [
            r.choice(corner) if word == "f" else repr(r.uniform(-2, 2))
            for _ in range(r.choice([3, 3, 3, 3, 2, 4, 6, 0]))
        ]
        return " ".join([word, *values])

    return "\n".join(line() for _ in range(r.randrange(60))).encode()


def off_body(r: Generator) -> bytes:
    head = r.choice(["OFF", "OFF", "OFF", "NOFF", "COFF", "STOFF", "4OFF", "nOFF", "OFF BINARY", "off", "OF"])
    count, width = r.choice([20, 20, 3, 0, integer(r)]), r.choice([3, 3, 6, 2])
    faces = r.choice([0, 0, 2, integer(r)])
    lines = [head, f"{count} {faces} 0"]
    lines += [" ".join(repr(r.uniform(-2, 2)) for _ in range(width)) for _ in range(min(max(count, 0), 20))]
    lines += [
        " ".join(str(r.choice([3, 0, 1, 2, 4, integer(r)])) for _ in range(4)) for _ in range(min(max(faces, 0), 4))
    ]
    return "\n".join(lines).encode()


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
