"""JSON that is none, that is too much, or that holds the wrong thing in every place."""

import base64
import json

from tests.service.hostile.cases import BODY, POINTS, REFUSED, TAKEN, Case, post

TEXT = BODY.decode()
ROWS = json.dumps(POINTS)

# No JSON, or JSON that only some parsers take.
BROKEN = {
    "nothing": b"", "a blank": b" ", "half": BODY[:-5], "twice": BODY + BODY, "a comma": b'{"points": [[0,0],]}',
    "a comment": b"/**/" + BODY, "single quotes": b"{'points': []}", "no quotes": b"{points: []}",
    "NaN": b'{"points": [[NaN,0],[1,0],[0,1]]}', "Infinity": b'{"points": [[Infinity,0],[1,0],[0,1]]}',
    "-Infinity": b'{"points": [[-Infinity,0]]}', "hexadecimal": b'{"points": [[0x1,0]]}',
    "a leading zero": b'{"points": [[01,0]]}', "a leading plus": b'{"points": [[+1,0]]}',
    "a point alone": b'{"points": [[1.,.5]]}', "UTF-16": TEXT.encode("utf-16"), "UTF-32": TEXT.encode("utf-32"),
    "invalid UTF-8": b'{"\xff": 1}', "overlong UTF-8": b'{"\xc0\xaf": 1}', "a surrogate": b'{"\\ud800": 1}',
    "a surrogate in bytes": b'{"\xed\xa0\x80": 1}', "a zero byte": b'{"points": "\x00"}',
    "a zero": b'{"a\\u0000b": 1}', "zeros behind": BODY + bytes(100), "two marks": b"\xef\xbb\xbf" * 2 + BODY,
    "an escape": b'{"\\x41": 1}', "a control character": b'{"a\nb": 1}', "a record separator": b"\x1e" + BODY,
    "gzip": b"\x1f\x8b\x08" + bytes(50), "an npy": b"\x93NUMPY\x01\x00", "XML": b"<points/>",
    "YAML": b"points: [[0,0]]", "a form": b"points=%5B%5D", "a pickle": b"\x80\x04\x95.",
    "MessagePack": b"\x81\xa6points\x90", "CBOR": b"\xa1fpoints\x80",
}  # fmt: skip
# Every one of these stands in every place below.
WRONG = [
    "null", "true", "0", "-0.0", "1e999", "-1e999", "1e-999", "9" * 400, "0." + "9" * 4000, "9007199254740993",
    "18446744073709551616", '""', '"x"', '"\\u0000"', "[]", "{}", "[[]]", "[null]", '{"a": {}}', '"1"',
    '["__import__"]', "1E400",
]  # fmt: skip
PLACES = {
    "the document": "%s",
    "points": '{"points": %s}',
    "a row": '{"points": [[0,0],[1,0],%s,[0,1],[1,1]]}',
    "a number": '{"points": [[0,0],[1,0],[0,%s],[1,1],[2,2]]}',
    "normals": '{"points": ' + ROWS + ', "normals": %s}',
    "options": '{"points": ' + ROWS + ', "options": %s}',
    "an option": '{"points": ' + ROWS + ', "options": {"max_degree": %s}}',
    "a dtype": '{"points": {"dtype": %s, "shape": [4, 2], "data": ""}}',
    "a shape": '{"points": {"dtype": "<f8", "shape": %s, "data": ""}}',
    "data": '{"points": {"dtype": "<f8", "shape": [4, 2], "data": %s}}',
}
DTYPES = [
    "O", "|O", "object", "<U99999", "V8", "<c16", "m8", "M8[ns]", "f16", "<f8,<f8", "i4, f8", "S8", "?", "<i16",
    "x" * 5000, "{'names': ['a']}", "<f8\u0000",
]  # fmt: skip


def broken() -> list[Case]:
    """Return bodies that are no JSON, or not the JSON that is asked for."""
    return [
        Case(name, (post(body),), REFUSED | (TAKEN if name == "two marks" else set())) for name, body in BROKEN.items()
    ]


def wrong() -> list[Case]:
    """Return every wrong value in every place. Some are not wrong there."""
    return [
        Case(f"{place}: {value[:30]} ({len(value)})", (post((text % value).encode()),), REFUSED | TAKEN)
        for place, text in PLACES.items()
        for value in WRONG
    ]


def packed() -> list[Case]:
    """Return packed arrays whose type is not one of numbers, or whose base64 is none."""
    data = base64.b64encode(bytes(64)).decode()
    found = {f"dtype {name[:20]}": {"dtype": name, "shape": [4, 2], "data": data} for name in DTYPES}
    found |= {
        f"data {text[:20]}": {"dtype": "<f8", "shape": [4, 2], "data": text}
        for text in (
            "=",
            "=" * 100,
            "A",
            "\u0000",
            "é",
            data + "=",
            data[:-1],
            data * 2,
            "-_" * 43,
            " " + data,
            data + "\n",
            "A" * 400_000,
        )
    }
    return [Case(name, (post(json.dumps({"points": one}).encode()),)) for name, one in found.items()]


def bombs() -> list[Case]:
    """Return JSON that is small to send and large to hold, or slow to read."""
    sent = {
        "100,000 lists deep": "[" * 100_000 + "]" * 100_000,
        "100,000 objects deep": '{"a":' * 100_000 + "1" + "}" * 100_000,
        "1 MB of open brackets": "[" * 1_000_000,
        "points, deep in a row": '{"points": [' + "[" * 900 + "]" * 900 + "]}",
        "100,000 members": json.dumps({f"k{i}": i for i in range(100_000)}),
        "100,000 times one member": "{" + '"points": 1,' * 100_000 + '"points": 1}',
        "points twice": '{"points": [], "points": ' + ROWS + "}",
        "a name of 1 MB": '{"' + "a" * 1_000_000 + '": 1}',
        "a text of 1 MB": '{"points": "' + "a" * 1_000_000 + '"}',
        "a number of 1 MB": '{"points": [[' + "9" * 1_000_000 + ",0]]}",
        "100,000 options": '{"points": '
        + ROWS
        + ', "options": '
        + json.dumps({f"k{i}": i for i in range(100_000)})
        + "}",
        "an option of 1 MB": '{"points": ' + ROWS + ', "options": {"preset": "' + "a" * 1_000_000 + '"}}',
        "the name of an option of 1 MB": '{"points": ' + ROWS + ', "options": {"' + "a" * 1_000_000 + '": 1}}',
        "400,000 empty rows": '{"points": [' + "[]," * 400_000 + "[]]}",
        "a row of 400,000 numbers": '{"points": [[' + "0," * 400_000 + "0]]}",
        "400,000 times the same point": '{"points": [' + "[0,0]," * 400_000 + "[0,0]]}",
        "one long text among numbers": '{"points": [' + "[0,0]," * 40_000 + '["' + "a" * 100_000 + '",0]]}',
        "1 MB of escapes": '{"' + "\\u0041" * 170_000 + '": 1}',
        "1 MB of blanks": " " * 1_000_000 + TEXT,
        "huge and tiny": '{"points": [[1e308,1e308],[-1e308,1e308],[1e-308,1],[0,-1e308]]}',
        "subnormal": '{"points": [[5e-324,0],[0,5e-324],[-5e-324,0],[0,-5e-324]]}',
        "one place": '{"points": [' + "[1,1]," * 20 + "[1,1]]}",
        "a line": '{"points": [[0,0],[1,1],[2,2],[3,3],[4,4]]}',
        "normals of nothing": '{"points": ' + ROWS + ', "normals": ' + json.dumps([[0, 0]] * 8) + "}",
    }
    return [Case(name, (post(text.encode()),), REFUSED | TAKEN) for name, text in sent.items()]
