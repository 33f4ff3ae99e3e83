"""Point sets in JSON that nobody means."""

import base64
import json
from typing import Any

from tests.service.bodies import sphere
from tests.service.grammars.draws import NAMES, TYPES, Generator, integer, scalar

BALL = sphere(20)


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
