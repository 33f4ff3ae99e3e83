"""The JSON of requests and responses: shapes, units and examples, for validation and the OpenAPI document."""

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from service.api.callback_schemas import CallbackResource
from service.api.problems import Problem
from service.choices import OneOf
from service.jobs.fit import FitStatus
from service.jobs.warning_codes import WARNING_CODES
from service.options import FitOptions
from service.problem_types import PROBLEM_TYPES

Row = Annotated[list[float], Field(min_length=2, max_length=6)]

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

    dtype: str = Field(description="numpy's name of the number type: `<f8`, `<f4`, …", examples=["<f8"])
    shape: list[int] = Field(min_length=2, max_length=2, description="Rows and columns.", examples=[[500, 3]])
    data: str = Field(description="Base64 of the bytes, row by row.")


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

    points: list[Row] | PackedArray = Field(
        description="(N, 2) or (N, 3): coordinates in the caller's frame and unit. 2D points may run along an outline."
    )
    normals: list[Row] | PackedArray | None = Field(
        None, description="(N, d): outward normals of any length. Without them they are estimated."
    )
    options: FitOptions = Field(default_factory=FitOptions, description="How to fit.")


class PointSet(BaseModel):
    """The points of a fit."""

    points: list[Row] = Field(description="(N, d): coordinates in the caller's frame and unit.")
    normals: list[Row] | None = Field(
        None, description="(N, d): outward unit normals, if the points came with normals."
    )


class Frame(BaseModel):
    """The normalised frame: local = (x − centre) / scale."""

    centre: list[float] = Field(description="(d,): the centroid of the points, caller's coordinates.")
    scale: float = Field(description="The mean radius, in the caller's unit.")


class Polynomial(BaseModel):
    """f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ, negative inside.

    In the Chebyshev basis the power u^e is replaced by T_e(t) along each axis, with t running from −1 to 1 over the
    bounds.
    """

    degree: int = Field(description="Total degree n.")
    basis: Literal["monomial", "chebyshev"] = Field(description="What the coefficients multiply.")
    exponents: list[list[int]] = Field(description="(m, d): the exponents of each coefficient, in graded order.")
    coefficients: list[float] = Field(description="(m,): without unit; f is about the distance in mean radii.")
    frame: Frame = Field(description="The frame in which the coefficients are given.")
    bounds: list[list[float]] = Field(
        description="(2, d): lower and upper corner, caller's coordinates: the box in which the fit was made and its "
        "zero set checked. Outside it nothing is promised."
    )


class Step(BaseModel):
    """One fit of the search: at a degree or, with `granularity=monomial`, at a column of it."""

    degree: int = Field(description="Total degree.")
    columns: int = Field(description="Coefficients in use.")
    dropped: int = Field(description="Coefficients left out because their columns are collinear with earlier ones.")
    d_dist: float = Field(description="D_dist = mean |f|/‖∇f‖ at the points, in mean radii.")
    d_smooth: float = Field(description="D_smooth = mean n·∇f/‖∇f‖ at the points, −1 … 1.")
    rss: float = Field(description="Residual sum of squares of the linear system, in squared mean radii.")
    gcv: float | None = Field(description="Generalised cross-validation; null where there are no rows to spare.")
    condition: float | None = Field(description="Estimated condition of the scaled system; null if singular.")
    seconds: float = Field(description="Wall-clock seconds.")
    ridged: int = Field(description="Coefficients damped by ridge regression.")
    bic: float | None = Field(description="Schwarz' criterion; null unless it was asked for.")
    loo: float | None = Field(
        description="Mean squared error at points left out one by one, in squared mean radii; null unless asked for."
    )
    diagonal_ratio: float | None = Field(
        description="max |r_ii| / min |r_ii|, the paper's measure: a lower bound of the condition."
    )
    iterations: int = Field(description="Steps of the geometric fit; 0 if it is linear.")
    quiet: bool | None = Field(
        description="Whether the zero set keeps to the points and is whole; null if that was not looked at."
    )


class Diagnostics(BaseModel):
    """The delivered polynomial, seen from the data. Distances are in mean radii."""

    d_dist: float = Field(description="Mean of |f|/‖∇f‖ at the points.")
    d_smooth: float = Field(description="Mean of n·∇f/‖∇f‖ at the points.")
    distance_p95: float = Field(
        description="95th percentile of |f|/‖∇f‖ at the points; of many, at a sample of 50,000."
    )
    distance_max: float = Field(description="Maximum of |f|/‖∇f‖ at the points.")
    stray: float | None = Field(
        description="Share of the zero set's length or area, within the bounds, that lies away from all points; null "
        "if there is no zero set, or it was not measured."
    )
    components: int | None = Field(
        description="Connected components of the zero set within the bounds; 0 if there is none, null if not measured."
    )
    normal_source: Literal["given", "outline", "estimated"] = Field(description="Where the normals came from.")
    normal_self_check: float = Field(
        description="Share of points whose normal agrees with the inside that all normals describe, 0 … 1."
    )
    bounded: bool | None = Field(
        description="Whether the leading form is definite, so that no part of the zero set runs to infinity."
    )
    orthogonality_loss: float | None = Field(
        description="‖QᵀQ − I‖₂ of the paper's eq. (5); null where another factorisation keeps it at rounding."
    )
    quiet: bool | None = Field(
        description="Whether the zero set keeps to the points (and the gaps between them) and is whole, within the "
        "bounds; null if no signs were asked for."
    )
    unsure: float | None = Field(
        description="Share of the bounds, away from the points, where they do not tell inside from outside."
    )
    outliers: float | None = Field(description="Share of the points that a robust fit left out; null without it.")
    merged: int = Field(0, description="How many points were copies of others; each place is fitted once.")
    coverage: float | None = Field(
        None,
        description="Share of the points with a zero of f within 3 t1, shown by a change of its sign; null in results "
        "of versions that did not measure it.",
    )


class FitWarning(BaseModel):
    """What a careful user should know of a result."""

    code: Annotated[str, OneOf(WARNING_CODES)] = Field(
        description="What it is about; docs/warnings.md lists causes and remedies."
    )
    message: str = Field(description="What was found, what most likely caused it, and what to do about it.")


class Engine(BaseModel):
    """What makes the answer repeatable, together with the options."""

    version: str = Field(description="Version of ipfit.")
    input_sha256: str = Field(description="SHA-256 of points and normals, as doubles.")


class Parts(BaseModel):
    """The parts of a fit that was split over workers, because its points are so many."""

    summed: int = Field(description="How many of them have ended.")
    total: int = Field(description="How many there are.")


class FitSummary(BaseModel):
    """A fit, without its progress and its result."""

    id: str = Field(description="Names the fit in `/v1/fits/{id}`.")
    status: Annotated[str, OneOf(FitStatus)] = Field(
        description="Accepted and running fits are live; the others have ended."
    )
    created: datetime = Field(description="When it was accepted, UTC.")
    started: datetime | None = Field(description="When a worker last took it up, UTC.")
    finished: datetime | None = Field(description="When it ended, UTC.")
    dimension: int = Field(description="d, 2 or 3.")
    points: int = Field(description="N, the number of points.")
    options: dict[str, Any] = Field(description="As asked for; with defaults filled in when successful.")
    problem: Problem | None = Field(None, description="Why it failed.")


class FitList(BaseModel):
    """A page of fits."""

    fits: list[FitSummary] = Field(description="Newest first.")
    next: str | None = Field(description="The address of the next page; null if this is the last.")


class FitResource(FitSummary):
    """A fit. The members from `polynomial` on are there when it is successful, `problem` when it failed."""

    callback: CallbackResource | None = Field(None, description="Who is told of its end, if that was asked for.")
    progress: list[Step] = Field(default_factory=list, description="The degrees tried so far, while it is running.")
    parts: Parts | None = Field(None, description="How far its parts are, if it has any, while it is live.")
    polynomial: Polynomial | None = Field(None, description="The answer.")
    stop_reason: (
        Literal["criterion-met", "criterion-minimum", "degree-reached", "max-degree", "too-few-points", "planar"] | None
    ) = Field(None, description="Why no higher degree was tried.")
    steps: list[Step] | None = Field(None, description="Every degree, or column, that was tried.")
    diagnostics: Diagnostics | None = Field(None, description="How good the answer is.")
    warnings: list[FitWarning] | None = Field(None, description="What a careful user should know.")
    engine: Engine | None = Field(None, description="What made the answer.")


class ProblemKind(BaseModel):
    """A type of problem."""

    type: str = Field(description="Its address on this server.")
    code: Annotated[str, OneOf(PROBLEM_TYPES)] = Field(description="Its stable name.")
    title: str = Field(description="What it is, in words.")
    status: int | None = Field(description="The HTTP status; null if it stands in failed fits only.")
    remedy: str = Field(description="When it occurs, and what the caller can do.")


class ProblemKindList(BaseModel):
    """All types of problems."""

    problems: list[ProblemKind] = Field(description="In the order of their statuses.")


class Health(BaseModel):
    """The server's state in a word."""

    status: Literal["ok"] = Field(description="`ok`.")
