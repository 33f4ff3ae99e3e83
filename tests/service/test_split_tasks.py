"""The tasks of a fit in parts give the result of the whole, also above the degree up to which moments are summed."""

from datetime import UTC, datetime
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest

import ipcore
from ipcore import shapes
from service.formats.points import decode
from service.jobs.errors import NotReadyError
from service.jobs.fit import Fit, FitStatus, PointSetRef
from service.jobs.parts import split
from service.jobs.requested_options import RequestedOptions
from service.jobs.slices import Frame, Slice
from service.store.blobs import Blobs
from service.workers import tasks
from tests.service.bodies import Array, npy

LINEAR: dict[str, Any] = {"geometric": False, "t1": 0.0, "measure_zero_set": False}
CHOSEN = RequestedOptions(LINEAR).complete


def noisy(shape: shapes.Shape, count: int) -> Array:
    points, normals = shape.sample(count)
    moved = points + np.random.default_rng(0).normal(scale=0.02, size=points.shape)
    return np.hstack([37.0 * moved + 1000.0, normals])


@pytest.mark.parametrize(
    ("dimension", "options", "summed"),
    [
        (2, {"max_degree": 9}, 9),
        (2, {"max_degree": 18}, 16),  # above it, squaring the condition shows, and the rows are factored
        (2, {"max_degree": 18, "criterion": "none"}, 18),
        (3, {"max_degree": 7, "constraints": "5l", "criterion": "bic"}, 7),
        (3, {"max_degree": 14}, 13),
    ],
)
def test_parts_and_rest_are_the_fit(tmp_path: Path, dimension: int, options: dict[str, Any], summed: int) -> None:
    table = noisy(shapes.ellipse() if dimension == 2 else shapes.torus(), 2500)
    read, blobs, requested = (
        decode.read(npy(table), "npy", 2500),
        Blobs(str(tmp_path)),
        RequestedOptions(LINEAR | options),
    )
    assert read.frame is not None
    given, chosen = PointSetRef(blobs.put(read.content), dimension, 2500, summary=read.summary), requested.complete
    fit = Fit("one", FitStatus.ACCEPTED, given, requested, datetime.now(UTC))
    parts = [one.slice for one in split(fit, read.frame, 700)[1]]
    sums = [tasks.sum_moments(blobs, given, chosen, some) for some in parts if some is not None]
    assert [ipcore.Moments.load(BytesIO(one)).degree for one in sums] == [summed] * 4
    rest = orjson.loads(tasks.fit_from_moments(blobs, given, chosen, sums))
    whole = orjson.loads(tasks.fit(blobs, given, chosen))
    assert rest["polynomial"]["frame"] == whole["polynomial"]["frame"]
    assert [step["degree"] for step in rest["steps"]] == [step["degree"] for step in whole["steps"]]
    for one, other in zip(rest["steps"], whole["steps"], strict=True):
        assert one["d_dist"] == pytest.approx(
            other["d_dist"], rel=1e-8, abs=1e-9
        )  # `ipcore.linear.q_less`'s own rounding
    f, g = (ipcore.ImplicitPolynomial.from_dict(one["polynomial"]) for one in (rest, whole))
    np.testing.assert_allclose(f(table[:, :dimension]), g(table[:, :dimension]), atol=1e-8)


def test_a_part_that_is_missing_or_comes_twice_is_noticed(tmp_path: Path) -> None:
    blobs, read = Blobs(str(tmp_path)), decode.read(npy(noisy(shapes.torus(), 900)), "npy", 900)
    assert read.frame is not None
    given = PointSetRef(blobs.put(read.content), 3, 900)
    sums = [tasks.sum_moments(blobs, given, CHOSEN, Slice(i, i + 300, read.frame)) for i in (0, 300, 600)]
    for wrong in (sums[:2], [*sums, sums[0]]):
        with pytest.raises(ipcore.InvalidPointsError, match="these are moments of"):
            tasks.fit_from_moments(blobs, given, CHOSEN, wrong)


def test_points_that_are_away_are_no_fault_of_the_part(tmp_path: Path) -> None:
    with pytest.raises(NotReadyError, match="cannot be read"):
        tasks.sum_moments(
            Blobs(str(tmp_path)), PointSetRef("0" * 64, 3, 9), CHOSEN, Slice(0, 9, Frame((0.0, 0.0, 0.0), 1.0))
        )


@pytest.mark.parametrize("normals", [True, False])
def test_a_stored_point_set_is_fitted_as_the_library_fits_it(tmp_path: Path, *, normals: bool) -> None:
    table = noisy(shapes.ellipse(), 300)
    read, blobs = decode.read(npy(table if normals else table[:, :2]), "npy", 300), Blobs(str(tmp_path))
    given = PointSetRef(blobs.put(read.content, read.key), 2, 300, summary=read.summary)
    fitted = orjson.loads(tasks.fit(blobs, given, CHOSEN))
    expected = ipcore.fit(table[:, :2], table[:, 2:] if normals else None, CHOSEN).to_dict()
    assert fitted["polynomial"]["coefficients"] == list(expected["polynomial"]["coefficients"])
    assert fitted["engine"]["input_sha256"] == expected["engine"]["input_sha256"]
    earlier = orjson.loads(tasks.fit(blobs, PointSetRef(given.key, 2, 300), CHOSEN))  # as version 0.1 stored it
    assert earlier["polynomial"]["frame"] == fitted["polynomial"]["frame"]
