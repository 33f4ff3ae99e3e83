"""The limits of this server, checked before memory is taken."""

from dataclasses import dataclass
from math import comb
from typing import Any

from service.jobs.cost import DEFAULT_MAX_DEGREE, holds_system, rows_per_point
from service.jobs.errors import InvalidInputError, TooLargeError
from service.jobs.fit import PointSet


@dataclass(frozen=True)
class Limits:
    """What one request may ask for.

    Attributes
    ----------
    body_bytes
        Largest body.
    max_degree, resolution
        Highest, by dimension.
    system_bytes
        Largest linear system that is held at once: doubles, a row per equation, a column per coefficient.
    wait
        Longest wait, in seconds.

    """

    body_bytes: int
    max_degree: dict[int, int]
    resolution: dict[int, int]
    system_bytes: int
    wait: float

    def checked(self, points: PointSet, options: dict[str, Any]) -> dict[str, Any]:
        """Return the options, with this server's highest degree if it is below the library's default; refuse too much.

        Raises
        ------
        InvalidInputError
            If the degree is over the limit.
        TooLargeError
            If points and degree together are.

        """
        d, highest = points.dimension, self.max_degree[points.dimension]
        asked = options.get("max_degree")
        if asked is not None and asked > highest:
            raise InvalidInputError(
                f"max_degree may be at most {highest} for {d}D points here, not {asked}", ("options", "max_degree")
            )
        degree = asked if asked is not None else min(DEFAULT_MAX_DEGREE[d], highest)
        rows = points.points * rows_per_point(options.get("constraints", "3l"), d)
        size = 8 * rows * min(comb(degree + d, d), points.points)
        if holds_system(options) and size > self.system_bytes:
            raise TooLargeError(
                f"{points.points} points up to degree {degree} make a system of {size} bytes; {self.system_bytes} are "
                "allowed: lower max_degree, send fewer points, or take factor auto",
                ("options", "max_degree"),
            )
        return options if degree == (asked or DEFAULT_MAX_DEGREE[d]) else options | {"max_degree": degree}

    def check_resolution(self, resolution: int | None, dimension: int) -> None:
        """Refuse a grid that would be too large.

        Raises
        ------
        InvalidInputError
            If the resolution is over the limit.

        """
        if resolution is not None and resolution > self.resolution[dimension]:
            raise InvalidInputError(
                f"resolution may be at most {self.resolution[dimension]} in {dimension}D here, not {resolution}",
                ("resolution",),
            )
