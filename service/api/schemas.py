"""The JSON of responses: shapes and units, for the OpenAPI document."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from service.api.callback_schemas import CallbackResource
from service.api.fit_request import Rows
from service.api.problems import Problem
from service.api.proof_schemas import Proof
from service.api.schema_types import (
    ColumnCount,
    Count,
    Degree,
    Dimension,
    Exponents,
    FitIdText,
    Name,
    PathText,
    Sha256,
    Text,
    Time,
    Vector,
)
from service.choices import OneOf
from service.jobs.bounds import MOST_COEFFICIENTS
from service.jobs.fit import FitStatus
from service.jobs.warning_codes import WARNING_CODES
from service.problem_types import PROBLEM_TYPES

# One for each α, of which there are as many as coefficients.
Steps = Annotated[list["Step"], Field(max_length=MOST_COEFFICIENTS)]
MOST_WARNINGS = 50  # one for each code at most; results of version 0.1 have a few more without one


class PointSet(BaseModel):
    """The points of a fit."""

    points: Rows = Field(description="(N, d): coordinates in the caller's frame and unit.")
    normals: Rows | None = Field(None, description="(N, d): outward unit normals, if the points came with normals.")


class Frame(BaseModel):
    """The normalised frame: local = (x − centre) / scale."""

    centre: Vector = Field(description="(d,): the centroid of the points, caller's coordinates.")
    scale: float = Field(description="The mean radius, in the caller's unit.")


class Polynomial(BaseModel):
    """f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ, negative inside.

    In the Chebyshev basis the power u^e is replaced by T_e(t) along each axis, with t running from −1 to 1 over the
    bounds.
    """

    degree: Degree = Field(description="Total degree n.")
    basis: Literal["monomial", "chebyshev"] = Field(description="What the coefficients multiply.")
    exponents: list[Exponents] = Field(
        max_length=MOST_COEFFICIENTS, description="(m, d): the exponents of each coefficient, in graded order."
    )
    coefficients: list[float] = Field(
        max_length=MOST_COEFFICIENTS, description="(m,): without unit; f is about the distance in mean radii."
    )
    frame: Frame = Field(description="The frame in which the coefficients are given.")
    bounds: list[Vector] = Field(
        min_length=2,
        max_length=2,
        description="(2, d): lower and upper corner, caller's coordinates: the box in which the fit was made and its "
        "zero set checked. Outside it nothing is promised.",
    )


class Step(BaseModel):
    """One fit of the search: at a degree or, with `granularity=monomial`, at a column of it."""

    degree: Degree = Field(description="Total degree.")
    columns: ColumnCount = Field(description="Coefficients in use.")
    dropped: ColumnCount = Field(
        description="Coefficients left out because their columns are collinear with earlier ones."
    )
    d_dist: float = Field(description="D_dist = mean |f|/‖∇f‖ at the points, in mean radii.")
    d_smooth: float = Field(description="D_smooth = mean n·∇f/‖∇f‖ at the points, −1 … 1.")
    rss: float = Field(description="Residual sum of squares of the linear system, in squared mean radii.")
    gcv: float | None = Field(description="Generalised cross-validation; null where there are no rows to spare.")
    condition: float | None = Field(description="Estimated condition of the scaled system; null if singular.")
    seconds: float = Field(description="Wall-clock seconds.")
    ridged: ColumnCount = Field(description="Coefficients damped by ridge regression.")
    bic: float | None = Field(description="Schwarz' criterion; null unless it was asked for.")
    loo: float | None = Field(
        description="Mean squared error at points left out one by one, in squared mean radii; null unless asked for."
    )
    diagonal_ratio: float | None = Field(
        description="max |r_ii| / min |r_ii|, the paper's measure: a lower bound of the condition."
    )
    iterations: Count = Field(description="Steps of the geometric fit; 0 if it is linear.")
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
    components: Count | None = Field(
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
        description="Whether the zero set is proved to keep to the points (and the gaps between them) within the "
        "bounds, and was found whole; null if no signs were asked for, or it was not to be measured."
    )
    unsure: float | None = Field(
        description="Share of the bounds, away from the points, where they do not tell inside from outside."
    )
    outliers: float | None = Field(description="Share of the points that a robust fit left out; null without it.")
    merged: Count = Field(0, description="How many points were copies of others; each place is fitted once.")
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
    message: Text = Field(description="What was found, what most likely caused it, and what to do about it.")


class Engine(BaseModel):
    """What makes the answer repeatable, together with the options."""

    version: str = Field(
        max_length=100, pattern=r"^[0-9]+(\.[0-9]+)*[0-9A-Za-z.+!-]*$", description="Version of ipfit."
    )
    input_sha256: Sha256 = Field(description="SHA-256 of points and normals, as doubles.")


class Parts(BaseModel):
    """The parts of a fit that was split over workers, because its points are so many."""

    summed: Count = Field(description="How many of them have ended.")
    total: Count = Field(description="How many there are.")


class FitSummary(BaseModel):
    """A fit, without its progress and its result."""

    id: FitIdText = Field(description="Names the fit in `/v1/fits/{id}`.")
    status: Annotated[str, OneOf(FitStatus)] = Field(
        description="Accepted and running fits are live; the others have ended."
    )
    created: Time = Field(description="When it was accepted, UTC.")
    started: Time | None = Field(description="When a worker last took it up, UTC.")
    finished: Time | None = Field(description="When it ended, UTC.")
    dimension: Dimension = Field(description="d, 2 or 3.")
    points: Count = Field(description="N, the number of points.")
    options: dict[str, Any] = Field(description="As asked for; with defaults filled in when successful.")
    problem: Problem | None = Field(None, description="Why it failed.")


class FitList(BaseModel):
    """A page of fits."""

    fits: list[FitSummary] = Field(max_length=100, description="Newest first.")
    next: PathText | None = Field(description="The address of the next page; null if this is the last.")


class FitResource(FitSummary):
    """A fit. The members from `polynomial` on are there when it is successful, `problem` when it failed."""

    callback: CallbackResource | None = Field(None, description="Who is told of its end, if that was asked for.")
    progress: Steps = Field(default_factory=list, description="The degrees tried so far, while it is running.")
    parts: Parts | None = Field(None, description="How far its parts are, if it has any, while it is live.")
    polynomial: Polynomial | None = Field(None, description="The answer.")
    stop_reason: (
        Literal["criterion-met", "criterion-minimum", "degree-reached", "max-degree", "too-few-points", "planar"] | None
    ) = Field(None, description="Why no higher degree was tried.")
    steps: Steps | None = Field(None, description="Every degree, or column, that was tried.")
    diagnostics: Diagnostics | None = Field(None, description="How good the answer is.")
    proof: Proof | None = Field(
        None, description="What is proved of its zero set; null if that was not to be measured, or is seen to stray."
    )
    warnings: Annotated[list[FitWarning], Field(max_length=MOST_WARNINGS)] | None = Field(
        None, description="What a careful user should know."
    )
    engine: Engine | None = Field(None, description="What made the answer.")


class ProblemKind(BaseModel):
    """A type of problem."""

    type: PathText = Field(description="Its address on this server.")
    code: Annotated[str, OneOf(PROBLEM_TYPES)] = Field(description="Its stable name.")
    title: Name = Field(description="What it is, in words.")
    status: Annotated[int, Field(ge=400, le=599)] | None = Field(
        description="The HTTP status; null if it stands in failed fits only."
    )
    remedy: Text = Field(description="When it occurs, and what the caller can do.")


class ProblemKindList(BaseModel):
    """All types of problems."""

    problems: list[ProblemKind] = Field(max_length=100, description="In the order of their statuses.")


class Health(BaseModel):
    """The server's state in a word."""

    status: Literal["ok"] = Field(description="`ok`.")
