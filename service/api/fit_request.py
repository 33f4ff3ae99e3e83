"""The JSON of a point set in a request, for the OpenAPI document; `service.formats.points` reads it."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from service.api.schema_types import Count
from service.jobs.bounds import LARGEST_POINT_SET, MOST_BODY_BYTES
from service.options import FitOptions

Row = Annotated[list[float], Field(min_length=2, max_length=3)]
Rows = Annotated[list[Row], Field(min_length=1, max_length=LARGEST_POINT_SET)]

_ELLIPSE: JsonValue = [
    [5.0, 1.0], [4.73, 1.77], [4.0, 2.41], [3.0, 2.73], [2.0, 2.73], [1.0, 2.41],
    [0.27, 1.77], [0.0, 1.0], [0.27, 0.23], [1.0, -0.41], [2.0, -0.73], [3.0, -0.73],
    [4.0, -0.41], [4.73, 0.23],
]  # fmt: skip
_OCTAHEDRON: JsonValue = [
    [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0],
    [0.577, 0.577, 0.577], [-0.577, 0.577, 0.577], [0.577, -0.577, 0.577], [0.577, 0.577, -0.577],
    [-0.577, -0.577, 0.577], [-0.577, 0.577, -0.577], [0.577, -0.577, -0.577], [-0.577, -0.577, -0.577],
]  # fmt: skip


class PackedArray(BaseModel):
    """An array as base64 of its bytes."""

    model_config = ConfigDict(extra="forbid")

    dtype: str = Field(
        max_length=3,
        pattern="^[<>|=]?(i[1248]|u[1248]|f[248])$",
        description="numpy's name of the number type: `<f8`, `<f4`, …",
        examples=["<f8"],
    )
    shape: list[Count] = Field(min_length=2, max_length=2, description="Rows and columns.", examples=[[500, 3]])
    data: str = Field(
        max_length=MOST_BODY_BYTES, pattern="^[A-Za-z0-9+/]*={0,2}$", description="Base64 of the bytes, row by row."
    )


class FitRequest(BaseModel):
    """A point set to fit."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"points": _ELLIPSE, "options": {"max_degree": 6}},
                {"points": _OCTAHEDRON, "normals": _OCTAHEDRON, "options": {"max_degree": 2, "basis": "chebyshev"}},
            ]
        },
    )

    points: Rows | PackedArray = Field(
        description="(N, 2) or (N, 3): coordinates in the caller's frame and unit. 2D points may run along an outline."
    )
    normals: Rows | PackedArray | None = Field(
        None, description="(N, d): outward normals of any length. Without them they are estimated."
    )
    options: FitOptions = Field(default_factory=FitOptions, description="How to fit.")
