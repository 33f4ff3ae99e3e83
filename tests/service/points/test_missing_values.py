"""Missing values in npy, npz and JSON: refused, or left out."""

import base64
import json

import numpy as np
import pytest

from service.jobs.errors import InvalidInputError
from tests.service.bodies import npy
from tests.service.points.arrays import BALL, OUTLINE, gives, npz, read, refused


@pytest.mark.parametrize("kind", ["npy", "npz", "json", "packed"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("columns", [(0,), (1, 4), (5,)])
def test_points_with_missing_values_are_refused_or_left_out(kind: str, bad: float, columns: tuple[int, ...]) -> None:
    table = BALL.copy()
    table[[4, 9], columns[0]] = bad
    table[9, columns[-1]] = bad
    if kind == "json":
        rows = [[value if np.isfinite(value) else None for value in row] for row in table.tolist()]
        content = json.dumps({"points": [r[:3] for r in rows], "normals": [r[3:] for r in rows]}).encode()
    elif kind == "packed":
        halves = {"points": table[:, :3], "normals": table[:, 3:]}
        packed = {
            name: {"dtype": "<f8", "shape": [30, 3], "data": base64.b64encode(half.tobytes()).decode()}
            for name, half in halves.items()
        }
        content = json.dumps(packed).encode()
    else:
        content = npy(table) if kind == "npy" else npz(points=table[:, :3], normals=table[:, 3:])
    name = kind if kind in ("npy", "npz") else "json"
    error = refused(content, name)
    assert error.at[1] == 4
    found = read(content, name, missing="drop")
    kept = np.delete(BALL, [4, 9], axis=0)
    assert found.left_out == 2
    assert gives(found, kept[:, :3], kept[:, 3:])


def test_the_message_about_a_missing_value_says_how_to_leave_it_out() -> None:
    table = OUTLINE.copy()
    table[3, 1] = np.nan
    assert str(refused(npy(table))).endswith("missing=drop leaves such points out")
    assert "missing" not in str(refused(npy(np.ones((9, 2)))))


def test_normals_that_do_not_match_are_refused_even_if_missing_values_are_left_out() -> None:
    body = json.dumps({"points": OUTLINE.tolist(), "normals": OUTLINE[:9].tolist()}).encode()
    with pytest.raises(InvalidInputError, match="they must match"):
        read(body, "json", missing="drop")
