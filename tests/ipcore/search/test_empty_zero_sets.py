"""What is reported where there is no zero set."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import ipcore
from ipcore import FitOptions, shapes
from ipcore.fitting import choose_linear_fitter
from ipcore.options.choices import Preset
from ipcore.points.oriented import OrientedPoints
from ipcore.points.validation import check
from ipcore.search.criteria import stopping_criterion
from ipcore.search.degree_search import DegreeSearch
from ipcore.search.diagnostics import diagnose

OPTIONS = FitOptions.of(geometric=False, criterion="none")


@pytest.mark.parametrize("make", [shapes.circle, shapes.superellipse, shapes.sphere, shapes.torus])
@pytest.mark.parametrize("raised", [50.0, -500.0])
def test_without_a_zero_set_there_are_no_components_and_no_stray_share(
    make: Callable[[], shapes.Shape], raised: float
) -> None:
    points, normals = make().sample(400)
    data = OrientedPoints.of(check(points, normals), 4)
    fitter = choose_linear_fitter(data, OPTIONS, 2)
    best, _ = DegreeSearch(data, OPTIONS, fitter, stopping_criterion(OPTIONS)).run([4], None)
    f = best.fit.polynomial
    lifted = replace(f, coefficients=f.coefficients + raised * (np.arange(len(f.coefficients)) == 0))
    some, none = (diagnose(best, delivered, data, OPTIONS, None)[0] for delivered in (f, lifted))
    assert (none.components, none.stray) == (0, None)
    assert some.components
    assert some.stray is not None


@pytest.mark.parametrize("preset", list(Preset))
def test_an_unmeasured_zero_set_has_neither(preset: Preset) -> None:
    found = ipcore.fit(*shapes.circle().sample(100), FitOptions.of(preset, measure_zero_set=False)).diagnostics
    assert (found.components, found.stray) == (None, None)
