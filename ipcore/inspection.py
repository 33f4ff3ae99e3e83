"""All surveys of a fit, one after the other, and what they ask for."""

import numpy as np

from ipcore import contraction
from ipcore._typing import FloatArray
from ipcore.repair import demands
from ipcore.sides import Sides
from ipcore.signs import BEYOND, SignPoints
from ipcore.survey import Findings, Survey

# Lines per axis, and by what factor the bounds are grown. The first is as fine as the report of the zero set, so that
# the two agree; the second must find nothing, either.
SURVEYS = {2: ((240, 1.0), (501, BEYOND)), 3: ((88, 1.0), (129, BEYOND))}
WEIGHT = 0.02  # of each place that is asked for, against a mean squared distance


class Inspection:
    """The surveys that a fit has to pass."""

    def __init__(self, sides: Sides, bounds: FloatArray) -> None:
        """Take the sides and the bounds (2, d)."""
        self._sides, self._dimension = sides, bounds.shape[1]
        self._surveys = [Survey(sides, bounds, *grid) for grid in SURVEYS[self._dimension]]

    def look(self, degree: int, a: FloatArray) -> tuple[Findings, SignPoints | None]:
        """Return the findings of the first survey that asks for anything, and what it asks for; else of the last."""
        tensor = contraction.to_tensor(a, self._dimension, degree)
        for survey in self._surveys:
            found = survey.look(tensor)
            suspicious = found.suspect.any() or len(found.specks) > 0
            asked = demands(found, survey, self._sides) if suspicious else None
            if asked is not None:
                weight = np.full(len(asked.t), WEIGHT)
                return found, SignPoints(asked.t, asked.side, asked.margin, weight)
        return found, None
