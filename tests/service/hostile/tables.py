"""Text tables that are long, ragged, in other alphabets, or no tables."""

from tests.service.hostile.cases import CSV, REFUSED, TAKEN, Case, post

ROWS = "0,0\n1,0\n2,1\n1,2\n0,1\n"
CELLS = [
    "nan", "inf", "-inf", "1e999", "-1e999", "1e-999", "1_0", "0x1", "1d0", "1,5", "1;5", '"1"', '"', "'1'", "=1+1",
    "@SUM(1)", "\uff11", "٣", "½", "∞", "−1", "1e", "e1", ".", "-", "+", "--1", "1.2.3", "9" * 400, "9" * 60_000,
    "9" * 70_000, "0." + "1" * 5000, "\x00", "1\x00", "\ufeff1", "\u202e1", "None", "null", "True", "1+2j", "1/2",
    "1%", "$1", "\t", "\u00a01", "1\u2028",
]  # fmt: skip
HEADERS = [
    "x", "x,y,z", "x,x", "y", "X,Y,Z,NX", "x,y,nx", "a,b", ",", "x;y", "x y", '"x","y"', "x,y" + ",_" * 3000,
    "x," + "y" * 60_000, "é,ü", "x,y,nz", "__proto__,y", "x,y,x", "#x,y", "//x y",
]  # fmt: skip
FILES = {
    "nothing": b"", "a line end": b"\n", "a line without end": b"1,2",
    "line ends of Mac": ROWS.replace("\n", "\r").encode(), "mixed line ends": b"0,0\r1,0\n2,1\r\n0,1",
    "1 MB without a line end": b"1," * 500_000, "1 MB of one digit": b"1" * 1_000_000,
    "1 MB of commas": b"," * 1_000_000, "1 MB of line ends": b"\n" * 1_000_000, "1 MB of quotes": b'"' * 1_000_000,
    "an open quote": b'x,y\n"0,0\n' + ROWS.encode() * 10_000, "1 MB of comments": b"#\n" * 500_000 + ROWS.encode(),
    "1 MB of blanks": b" " * 1_000_000, "ragged in the end": ROWS.encode() * 10_000 + b"1\n",
    "100,000 columns": b",".join([b"1"] * 30_000) + b"\n", "UTF-16": ROWS.encode("utf-16"),
    "UTF-16 without mark": ROWS.encode("utf-16-le"), "UTF-32": ROWS.encode("utf-32"), "invalid UTF-8": b"\xff,\xfe\n",
    "half a UTF-16": ROWS.encode("utf-16")[:-1], "zeros": bytes(100_000),
    "a count that is wrong": b"9999999999\n" + ROWS.encode(),
    "an index that is huge": b"x,y\n" + (b"9" * 5000 + b",0,1\n") * 5,
    "a count that is huge": b"9" * 5000 + b"\n" + ROWS.encode(), "a zip": b"PK\x03\x04" + bytes(100),
    "a formula": b"=cmd|'/c calc'!A1,0\n" + ROWS.encode(), "vertical tabs": b"0\x0b0\n1\x0c0\n",
    "two delimiters": b"0,0;1\n1;0,2\n", "form feeds": b"0,0\x0c1,0\x0c",
    "escape codes": b"\x1b[2J,0\n" + ROWS.encode(), "next lines": "0,0\u00851,0\u20282,1".encode(),
}  # fmt: skip
COLUMNS = [
    "x,y", "x", "", ",", "x,y,z", "x,x", "y,x", "_,_", "x,y," + "_," * 5000, "x,y,nx,ny", "é", "%00", "x%2Cy", "X,Y",
    "x y", "x;y", "x,y,q", "nx,ny", "0,1", "%FF", "../x",
]  # fmt: skip
MISSING = ["refuse", "drop", "", "DROP", "%00", "é", "drop,refuse", "1"]


def cells() -> list[Case]:
    """Return tables with a strange cell, kept and left out."""
    return [
        Case(
            f"{cell[:20]!r} ({len(cell)}) {how}",
            (post(f"{ROWS}{cell},3\n".encode(), CSV, f"missing={how}"),),
            REFUSED | TAKEN,
        )
        for cell in CELLS
        for how in ("refuse", "drop")
    ]


def files() -> list[Case]:
    """Return whole files: headers, and what is no table."""
    found = {f"header {line[:20]} ({len(line)})": f"{line}\n{ROWS}".encode() for line in HEADERS} | FILES
    return [Case(name, (post(body, CSV),), REFUSED | TAKEN) for name, body in found.items()]


def readings() -> list[Case]:
    """Return a good table that is to be read in a strange way."""
    found = {f"columns={value[:30]}": f"columns={value}" for value in COLUMNS} | {
        f"missing={v}": f"missing={v}" for v in MISSING
    }
    return [Case(name, (post(ROWS.encode(), CSV, query),), REFUSED | TAKEN) for name, query in found.items()]
