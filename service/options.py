"""The options of a fit as JSON, query parameters and arguments of the command line.

Options come in here as strings and leave as `ipcore.FitOptions`; no other module converts them. Each field says what
the option is for, when to change it and what that costs. Choices come from the library's enumerations, and whether the
options agree with each other is checked by the library.
"""

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

import ipcore
from service.choices import OneOf
from service.jobs.errors import InvalidInputError, json_pointer
from service.jobs.requested_options import RequestedOptions

# Options in a body are counted before they are looked at, and a long name is not repeated in the answer.
MOST_OPTIONS, LONGEST_NAME = 50, 64


class FitOptions(BaseModel):
    """The options of a fit. Distances are in mean radii: the mean distance of the points from their centroid."""

    model_config = ConfigDict(extra="forbid")

    preset: Annotated[ipcore.Preset, OneOf(ipcore.Preset)] = Field(
        ipcore.Preset.DEFAULT,
        description="Which defaults the other options have. `paper` is the algorithm of 2007 to the letter: column by "
        "column, eq. (5), collinear columns dropped, ridge of eq. (8). Take it to compare with the literature; it "
        "loses orthogonality at high degree and is many times slower.",
    )
    max_degree: int | None = Field(
        None,
        ge=1,
        le=40,
        description="Last degree to try: 1 … 40 in 2D (default 20), 1 … 20 in 3D (default 16). Lower it for a compact "
        "answer or a bound on time, raise it for fine detail; time grows with the square of the number of "
        "coefficients.",
    )
    constraints: Annotated[ipcore.Constraints, OneOf(ipcore.Constraints)] = Field(
        ipcore.Constraints.THREE_LAYER,
        description="What is asked of f at each point. `3l`: its value on three layers. `5l` and `3l+gradient` hold "
        "the gradient better at high degree, for twice the rows. `gradient-one`, `min-max`, `min-var`: value and "
        "gradient on the points alone; for noisy normals weigh the gradient down. `taubin` needs no normals and is "
        "exact on algebraic shapes, but unstable at high degree.",
    )
    layer_distance: float = Field(
        0.05,
        gt=0,
        le=0.3,
        description="c, the distance of the outer layers from the points, in mean radii, in linear fits with layers "
        "(`geometric=false`). Lower it where parts are thinner than 2c, raise it for noise larger than c/5. Costs "
        "nothing.",
    )
    gradient_weight: float = Field(
        0.005,
        gt=0,
        le=100,
        description="μ, the weight of gradient rows against value rows, in linear fits with `constraints` that have "
        "them. Lower it for noisy normals. Costs nothing.",
    )
    criterion: Annotated[ipcore.Criterion, OneOf(ipcore.Criterion)] = Field(
        ipcore.Criterion.DISTANCE,
        description="When to stop. `distance`: D_dist < t1 and D_smooth > t2. On noisy points, which never get that "
        "close, `gcv`, `bic` or `loo` (leave one point out) take the degree that predicts best, after trying a few "
        "more. `none` goes to max_degree and returns it.",
    )
    t1: float = Field(
        0.01,
        ge=0,
        allow_inf_nan=False,
        description="Close enough when D_dist < t1, in mean radii. Raise it to about the noise, lower it for detail: "
        "the degree follows.",
    )
    t2: float = Field(
        0.95,
        ge=-1,
        le=1,
        description="Smooth enough when D_smooth > t2, a mean cosine. Lower it for shapes with many sharp corners. "
        "Linear fits have it with criterion `distance` only.",
    )
    granularity: Annotated[ipcore.Granularity, OneOf(ipcore.Granularity)] = Field(
        ipcore.Granularity.FORM,
        description="What is added between two tests: all monomials of a degree, or one. `form` does not depend on "
        "how the points are turned. `monomial` may save a few coefficients and tests, at its cost, after each of them.",
    )
    factor: Annotated[ipcore.Factor, OneOf(ipcore.Factor)] = Field(
        ipcore.Factor.AUTO,
        description="How the system is factored. `moments`: from sums over the points, for 3l and 5l, refined on the "
        "rows where squaring the condition would show; the fastest, in memory that does not grow with the points. "
        "`tsqr`: by chunks of rows, backward stable. `block`: all at once, Gram–Schmidt done twice. `gram-schmidt`: "
        "eq. (5) as printed, to compare with; it loses orthogonality from about degree 12 on. `auto` chooses.",
    )
    collinear: Annotated[ipcore.Collinear, OneOf(ipcore.Collinear)] | None = Field(
        None,
        description="What is done with a column that earlier ones explain: leave it out (the default), regularise it "
        "(the default of the selective ridge), or nothing.",
    )
    collinear_tol: float = Field(
        1e-10,
        ge=0,
        le=1,
        description="A column is collinear when at most this share of its length is new. For linear fits.",
    )
    ridge: Annotated[ipcore.Ridge, OneOf(ipcore.Ridge)] = Field(
        ipcore.Ridge.NONE,
        description="Ridge regression: of every column, or only of those near collinear. It calms a high degree on "
        "few or noisy points, and costs closeness.",
    )
    ridge_matrix: Annotated[ipcore.RidgeMatrix, OneOf(ipcore.RidgeMatrix)] = Field(
        ipcore.RidgeMatrix.INVARIANT,
        description="D of the ridge, if there is one: that of the paper's appendix, which no rotation changes, or the "
        "identity.",
    )
    ridge_strength: float = Field(
        1e-4,
        gt=0,
        le=1e6,
        description="κ of the ridge, if there is one. Raise it until the zero set is calm enough; D_dist rises with "
        "it.",
    )
    signs: bool | None = Field(
        None,
        description="Whether f is told to be positive outside and negative inside, away from the points, so that no "
        "stray curve or sheet is left there. Alone, with `geometric` off, it is quick, but needs a higher degree.",
    )
    geometric: bool | None = Field(
        None,
        description="Whether to minimise distances and angles themselves, from a linear start: a lower degree is as "
        "close. Off, the fit is linear and faster. Both are on unless you choose what only a linear fit has: other "
        "`constraints`, `granularity`, `factor`, `collinear` or `ridge`, or `criterion` gcv, bic or loo.",
    )
    angle_weight: float = Field(
        0.001,
        gt=0,
        le=1,
        description="λ, the weight of normals against distances in the geometric fit. Lower it for noisy normals.",
    )
    robust: bool = Field(
        default=False,
        description="Whether points far from the fit are left out. For data with outliers; D_dist and D_smooth are "
        "then those of the others.",
    )
    neighbours: int = Field(
        12,
        ge=3,
        le=100,
        description="Neighbours that estimate a normal, when no normals are given. Raise it for noise, lower it for "
        "thin parts and sharp edges.",
    )
    basis: Annotated[ipcore.Basis, OneOf(ipcore.Basis)] = Field(
        ipcore.Basis.MONOMIAL,
        description="What the coefficients multiply: powers of (x − centre)/scale, or products of Chebyshev "
        "polynomials on the bounds, which keep more digits at high degree.",
    )
    measure_zero_set: bool = Field(
        default=True,
        description="Whether to prove where the zero set lies, and report its stray share and number of components; "
        "without it a fit of few points is several times faster.",
    )


def requested(body: dict[str, Any], query: dict[str, Any] | None = None) -> RequestedOptions:
    """Return the options of a request; those in the query take the place of those in the body.

    Parameters
    ----------
    body
        Options by name, from JSON, unchecked.
    query
        Options by name that `FitOptions` has validated.

    Raises
    ------
    InvalidInputError
        If an option is unknown, has a value that is not allowed, or contradicts another; `at` names it.

    """
    _check_names(body)
    try:
        given = FitOptions.model_validate(body, strict=True).model_dump(exclude_unset=True)
    except ValidationError as error:
        first = error.errors()[0]
        at = ("options", *first["loc"])
        raise InvalidInputError(f"{json_pointer(at)}: {first['msg']}", at) from error
    return agreeing({**given, **(query or {})})


def _check_names(body: dict[str, Any]) -> None:
    """Refuse more options than are looked at, and names that are longer than any option's.

    Raises
    ------
    InvalidInputError
        If there are.

    """
    if len(body) > MOST_OPTIONS:
        raise InvalidInputError(f"{len(body)} options are more than the {MOST_OPTIONS} that are allowed", ("options",))
    long = next((name for name in body if len(name) > LONGEST_NAME), None)
    if long is not None:
        raise InvalidInputError(
            f"there is no option with a name of {len(long)} characters", ("options", f"{long[:LONGEST_NAME]}…")
        )


def agreeing(given: dict[str, Any]) -> RequestedOptions:
    """Return options whose values were validated one by one, once the library has checked them together.

    Raises
    ------
    InvalidInputError
        If two contradict each other; `at` names one.

    """
    options = RequestedOptions(given)
    try:
        _ = options.complete
    except ipcore.InvalidOptionsError as error:
        raise InvalidInputError(str(error), ("options", *error.at)) from error
    return options
