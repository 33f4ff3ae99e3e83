from dataclasses import replace

import numpy as np
import pytest

import ipcore
from ipcore import Constraints, FitOptions, shapes
from ipcore.errors import InvalidOptionsError

QUICK = FitOptions(measure_zero_set=False)


@pytest.mark.parametrize("family", Constraints)
@pytest.mark.parametrize("granularity", ["form", "monomial"])
def test_a_fixed_degree_is_what_the_search_has_at_that_degree(family: Constraints, granularity: str) -> None:
    points, normals = shapes.superellipse().sample(300)
    options = FitOptions.of(
        constraints=family,
        granularity=granularity,
        criterion="none",
        max_degree=5,
        geometric=False,
        measure_zero_set=False,
    )
    trace = ipcore.fit(points, normals, options).steps
    fixed = ipcore.fit_fixed(points, normals, QUICK, degree=3, method=str(family))
    (step,) = fixed.steps
    same = next(s for s in trace if s.alpha == 10)
    assert fixed.degree == step.degree == 3
    assert fixed.options.constraints is family
    assert step.d_dist == pytest.approx(same.d_dist, rel=1e-8)
    assert step.rss == pytest.approx(same.rss, rel=1e-8)


def test_a_fixed_degree_out_of_range_is_refused() -> None:
    points, normals = shapes.circle().sample(20)
    for degree, reason in ((0, "from 1 to 40"), (41, "from 1 to 40"), (6, "28 coefficients, more than 20 points")):
        with pytest.raises(InvalidOptionsError, match=reason) as caught:
            ipcore.fit_fixed(points, normals, degree=degree)
        assert caught.value.at == ("degree",)
    # one coefficient more than points, for f and its multiples have the same zero set
    assert ipcore.fit_fixed(points[:14], normals[:14], QUICK, degree=4, method="3l").degree == 4
    with pytest.raises(InvalidOptionsError, match="method must be 3l or"):
        ipcore.fit_fixed(points, normals, degree=2, method="2l")


def test_a_ridged_fit_can_be_returned_in_the_chebyshev_basis() -> None:
    points, normals = shapes.torus().sample(800)
    both = [
        ipcore.fit_fixed(
            points, normals, FitOptions.of(ridge="full", basis=basis, measure_zero_set=False), degree=6
        ).polynomial
        for basis in ("monomial", "chebyshev")
    ]
    assert [p.basis for p in both] == ["monomial", "chebyshev"]
    x = points + 0.1 * normals
    np.testing.assert_allclose(both[0](x), both[1](x), atol=1e-12)


def steps_without_time(result: ipcore.FitResult) -> list[ipcore.Step]:
    return [replace(step, seconds=0.0) for step in result.steps]


def test_a_fit_of_a_fixed_degree_reports_its_progress_and_does_not_depend_on_threads() -> None:
    points, normals = shapes.torus().sample(3000)
    seen: list[ipcore.Step] = []
    one, two = (
        ipcore.fit_fixed(points, normals, QUICK, degree=4, method="3l", progress=seen.append, threads=threads)
        for threads in (1, 2)
    )
    assert tuple(seen) == one.steps + two.steps
    np.testing.assert_allclose(one.polynomial.coefficients, two.polynomial.coefficients, rtol=1e-9, atol=1e-12)
