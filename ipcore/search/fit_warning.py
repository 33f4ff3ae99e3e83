"""A warning of a result: a code that programs can compare, and a sentence for a person."""

from dataclasses import dataclass
from enum import StrEnum


class WarningCode(StrEnum):
    """What a warning is about."""

    MAX_DEGREE = "max-degree"
    TOO_FEW_POINTS = "too-few-points"
    PLANAR = "planar"
    ILL_CONDITIONED = "ill-conditioned"
    INCOMPLETE_POINTS = "incomplete-points"
    COPIES_MERGED = "copies-merged"
    OUTLIERS = "outliers"
    FEW_POINTS_SET_UNIT = "few-points-set-unit"
    NORMALS_INWARD = "normals-inward"
    NORMALS_DOUBTFUL = "normals-doubtful"
    NO_ZERO_SET = "no-zero-set"
    LOW_COVERAGE = "low-coverage"
    NOT_QUIET = "not-quiet"
    SIDES_UNKNOWN = "sides-unknown"
    STRAY = "stray"
    ORTHOGONALITY_LOST = "orthogonality-lost"
    ROUNDING = "rounding"


@dataclass(frozen=True)
class FitWarning:
    """What a careful user should know of a result.

    Attributes
    ----------
    code
        What it is about; docs/warnings.md has a table of all codes.
    message
        What was found, what most likely caused it, and what to do about it.

    """

    code: WarningCode
    message: str

    def __str__(self) -> str:
        """Return the message."""
        return self.message

    def to_dict(self) -> dict[str, str]:
        """Return code and message, for JSON."""
        return {"code": str(self.code), "message": self.message}
