"""PLY, OBJ and OFF files that nobody means."""

import numpy as np

from tests.service.grammars.draws import NAMES, Generator, integer

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
