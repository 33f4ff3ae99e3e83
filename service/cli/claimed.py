"""What an answer claims of its zero set, as `ipfit verify` reads it: everything that is used is checked first."""

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from ipcore import HIGHEST_DEGREE
from service.jobs.errors import InvalidInputError

Vector = Annotated[list[FiniteFloat], Field(min_length=2, max_length=3)]
Exponent = Annotated[int, Field(ge=0)]


class _Read(BaseModel):
    """A part of an answer; what else stands in it is not used."""

    model_config = ConfigDict(strict=True)


class Frame(_Read):
    """The frame of the monomials."""

    centre: Vector
    scale: Annotated[FiniteFloat, Field(gt=0.0)]


class Polynomial(_Read):
    """The polynomial."""

    degree: Annotated[int, Field(ge=1)]
    basis: Literal["monomial", "chebyshev"]
    exponents: list[list[Exponent]]
    coefficients: list[FiniteFloat]
    frame: Frame
    bounds: Annotated[list[Vector], Field(min_length=2, max_length=2)]

    @model_validator(mode="after")
    def fits_together(self) -> Self:
        """Raise if the parts do not fit together."""
        d = len(self.frame.centre)
        if self.degree > HIGHEST_DEGREE[d]:
            raise ValueError(f"the degree must be at most {HIGHEST_DEGREE[d]} in {d} dimensions, not {self.degree}")
        if len(self.exponents) != len(self.coefficients):
            raise ValueError("there must be as many coefficients as exponents")
        if len({tuple(one) for one in self.exponents}) < len(self.exponents):
            raise ValueError("the same exponents stand there twice")
        if any(len(one) != d or sum(one) > self.degree for one in self.exponents):
            raise ValueError(f"exponents must be {d} numbers whose sum is at most the degree")
        low, high = self.bounds
        if len(low) != d or len(high) != d or not all(a < b for a, b in zip(low, high, strict=True)):
            raise ValueError(f"bounds must be a lower and an upper corner of {d} coordinates")
        return self


class Proof(_Read):
    """What is claimed."""

    within: Annotated[FiniteFloat, Field(ge=0.0)]
    holds: bool
    regular: bool


class Answer(_Read):
    """A result with a proof."""

    polynomial: Polynomial
    proof: Proof | None = None


def read(content: bytes) -> tuple[Polynomial, Proof]:
    """Return the polynomial and the proof of an answer in JSON.

    Raises
    ------
    InvalidInputError
        If it is not an answer, or claims nothing.

    """
    try:
        answer = Answer.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the answer"
        raise InvalidInputError(f"{where}: {first['msg']}") from error
    if answer.proof is None:
        raise InvalidInputError("the answer has no proof")
    if not answer.proof.holds:
        raise InvalidInputError("the answer claims nothing: `proof.holds` is false")
    return answer.polynomial, answer.proof


def check_dimension(polynomial: Polynomial, dimension: int) -> None:
    """Raise InvalidInputError if points of this dimension are not those of the polynomial."""
    if len(polynomial.frame.centre) != dimension:
        raise InvalidInputError(
            f"the points have {dimension} coordinates, the polynomial {len(polynomial.frame.centre)}"
        )
