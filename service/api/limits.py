"""The limits of this server on a request, checked before memory is taken."""

from dataclasses import dataclass

import ipcore
from service.jobs.errors import InvalidInputError, TooLargeError
from service.jobs.fit import ReceivedPoints
from service.jobs.requested_options import RequestedOptions


@dataclass(frozen=True)
class Limits:
    """The limits on a request.

    Attributes
    ----------
    body_bytes
        Bytes of the largest body.
    max_degree, resolution
        The highest that are allowed, by dimension.
    system_bytes
        Bytes of the largest linear system that is held as a whole: a double per equation and coefficient.
    wait
        The longest wait for a fit, in seconds.

    """

    body_bytes: int
    max_degree: dict[int, int]
    resolution: dict[int, int]
    system_bytes: int
    wait: float

    def capped(self, dimension: int, requested: RequestedOptions) -> RequestedOptions:
        """Return the options, with this server's highest degree as `max_degree` if that is below the default.

        Raises
        ------
        InvalidInputError
            If the caller gave a `max_degree` that is over the highest.

        """
        highest, given = self.max_degree[dimension], requested.complete.max_degree
        if given is not None and given > highest:
            raise InvalidInputError(
                f"max_degree may be at most {highest} for {dimension}D points here, not {given}",
                ("options", "max_degree"),
            )
        return requested if requested.complete.degree_cap(dimension) <= highest else requested.with_max_degree(highest)

    def check_system(self, points: ReceivedPoints, plan: ipcore.Plan) -> None:
        """Refuse a fit that would hold too large a linear system.

        Raises
        ------
        TooLargeError
            If it takes more than `system_bytes`.

        """
        if plan.held_bytes > self.system_bytes:
            raise TooLargeError(
                f"{points.points} points up to degree {plan.max_degree} make a system of {plan.held_bytes} bytes; "
                f"{self.system_bytes} are allowed: lower max_degree, send fewer points, or take factor auto",
                ("options", "max_degree"),
            )

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
