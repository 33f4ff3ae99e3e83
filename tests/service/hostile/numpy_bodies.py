"""npy files whose header lies, and archives in the place of an npy."""

import io
import pickle
import struct
import zipfile

from tests.service.bodies import ellipse, npy
from tests.service.hostile.cases import NPY, REFUSED, TAKEN, Case, post

MAGIC = b"\x93NUMPY"
GOOD = npy(ellipse(16))
SHAPES = [
    "(4, 2)", "(-4, 2)", "(4, -2)", "(-4, -2)", "(0, 2)", "(4, 0)", "(4,)", "()", "(4, 2, 1)", "(4, 2, 0)",
    "(2**62, 2)", "(4611686018427387904, 2)", "(9223372036854775807, 2)", "(9223372036854775808, 2)",
    "(4294967296, 4294967296)", "(1000000, 2)", "(1000001, 2)", "(99999999999, 2)", "(True, 2)", "(4.0, 2)",
    "('4', 2)", "[4, 2]", "4", "None", "(4, 2)" + ", " * 3, "(" + "1, " * 33 + ")", "(" + "1, " * 5000 + ")",
    "(4, 99999)", "(1e3, 2)", "(4j, 2)",
]  # fmt: skip
DTYPES = [
    "'|O'", "'O'", "'<f8'", "'<f16'", "'<c16'", "'|S8'", "'<U2'", "'|V8'", "'<m8[ns]'", "'<M8[s]'", "'|b1'", "'<f2'",
    "'>i8'", "'<u9'", "'<f-8'", "''", "None", "8", "[]", "[('x', '<f8'), ('y', '<f8')]",
    "[('x', '|O'), ('y', '<f8')]", "[('x', '<f8', (9999, 9999)), ('y', '<f8')]", "[('x', '<f8')]",
    "[('', '<f8'), ('', '<f8')]", "[('x', '<f8'), ('x', '<f8')]", "[('x', [('y', '<f8')])]",
    "[('" + "x" * 5000 + "', '<f8'), ('y', '<f8')]", "'<f8,<f8'", "('<f8', (2,))", "('<f8', (99999, 99999))",
    "{'names': ['x'], 'formats': ['<f8'], 'offsets': [999999999]}", "'float64'", "'d'", "'=f8'", "'<f8' * 99",
    '"<f8"',
]  # fmt: skip
HEADERS = {
    "no literal": "x", "a call": "__import__('os').system('true')", "a comprehension": "{x: 1 for x in 'ab'}",
    "no dictionary": "[1, 2]", "empty": "{}", "too few": "{'descr': '<f8'}",
    "too many": "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 2), 'x': 1}",
    "not closed": "{'descr': '<f8', ", "order of a text": "{'descr': '<f8', 'fortran_order': 'x', 'shape': (4, 2)}",
    "nested": "(" * 5000 + ")" * 5000, "a power": "{'descr': '<f8', 'fortran_order': False, 'shape': (9**9**9, 2)}",
    "a zero byte": "{'descr': '\x00', 'shape': (4, 2)}",
    "twice": "{'descr': '<f8', 'descr': '|O', 'fortran_order': False, 'shape': (4, 2)}",
    "no quotes": "{descr: '<f8'}", "Python 2": "{'descr': '<f8', 'fortran_order': False, 'shape': (4L, 2L)}",
    "long": "{" + " " * 60_000 + "}", "many": "{" + ", ".join(f"'{i}': {i}" for i in range(5000)) + "}",
    "bytes": "{'descr': b'<f8', 'fortran_order': False, 'shape': (4, 2)}",
    "line ends": "{\n\n'descr'\n:'<f8','fortran_order':False,'shape':(4,2)}", "minus": "-" * 5000 + "1",
    "a set": "{'descr'}",
}  # fmt: skip


def header(text: str, version: bytes = b"\x01\x00", length: int | None = None) -> bytes:
    """Return the beginning of an npy file with this header, whatever it says."""
    encoded = text.encode("utf-8") + b"\n"
    size = len(encoded) % 65536 if length is None else length  # a longer header does not say its length
    return MAGIC + version + struct.pack("<H" if version[:1] == b"\x01" else "<I", size) + encoded


def described(descr: str = "'<f8'", shape: str = "(4, 2)", order: str = "False") -> str:
    """Return a header's text."""
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"


def headers() -> list[Case]:
    """Return npy files whose shape, type or header is not what it must be."""
    content = bytes(range(64))
    found = {f"shape {shape[:30]} ({len(shape)})": header(described(shape=shape)) + content for shape in SHAPES}
    found |= {f"type {name[:40]} ({len(name)})": header(described(name)) + content for name in DTYPES}
    found |= {f"header: {name}": header(text) + content for name, text in HEADERS.items()}
    found |= {f"order {order}": header(described(order=order)) + content for order in ("True", "1", "None", "'C'")}
    return [Case(name, (post(body, NPY),), REFUSED | TAKEN) for name, body in found.items()]


def files() -> list[Case]:
    """Return files that are cut, of other versions, with other lengths, and archives and pickles."""
    found = {f"cut at {at}": GOOD[:at] for at in (0, 1, 5, 6, 7, 8, 9, 10, 11, 60, 127, 128, 129, len(GOOD) - 1)}
    found |= {
        f"version {v!r}": header(described(), v) + bytes(64)
        for v in (b"\x00\x00", b"\x02\x00", b"\x03\x00", b"\x01\x01", b"\xff\xff", b"\x09\x00")
    }
    found |= {f"length {n}": header(described(), length=n) + bytes(64) for n in (0, 1, 50, 1000, 65535)}
    found |= {
        f"length {n} of 4 bytes": header(described(), b"\x02\x00", n) + bytes(64)
        for n in (2**31, 2**32 - 1, 100_000_000)
    }
    found |= {
        "bytes behind": GOOD + b"x",
        "twice": GOOD * 2,
        "a pickle": pickle.dumps([[0.0, 1.0]] * 4),
        "a pickle in an npy": header(described("'|O'", "(1,)")) + b"cposix\nsystem\n(S'true'\ntR.",
        "a header of 2 MB": header("{" + " " * 2_000_000 + "}", b"\x02\x00") + bytes(64),
        "an npz": _archive("points.npy", GOOD),
        "a bomb": _archive("points.npy", bytes(5_000_000)),
        "nan and inf": npy([[float("nan"), 0.0], [float("inf"), 1.0], [0.0, 1.0], [2.0, 3.0]]),
        "zeros": npy([[0.0, 0.0]] * 100),
        "huge": npy([[1e308, 1e308], [-1e308, 1e308], [0.0, -1e308], [1e307, 0.0]]),
        "Fortran order": npy(ellipse(16), "F"),
    }
    return [Case(name, (post(body, NPY),), REFUSED | TAKEN) for name, body in found.items()]


def _archive(name: str, content: bytes) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return file.getvalue()
