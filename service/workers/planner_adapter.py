"""The adapter of the planner port: the library's predictions of time and memory."""

import ipcore
from service.jobs.errors import InvalidInputError
from service.jobs.fit import ReceivedPoints


class FitPlanner:
    """The planner that the use cases are given."""

    def plan(self, points: ReceivedPoints, options: ipcore.FitOptions) -> ipcore.Plan:
        """Return what a fit of these points with these options will take.

        Raises
        ------
        InvalidInputError
            If the options are not allowed for points of this dimension.

        """
        try:
            return ipcore.plan(points.dimension, points.points, options, normals=points.normals)
        except ipcore.InvalidOptionsError as error:
            raise InvalidInputError(str(error), ("options", *error.at)) from error
