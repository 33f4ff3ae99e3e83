"""`ipfit verify` on answers that are right, and on others."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pytest
from typer.testing import CliRunner, Result

import ipcore
from ipcore import shapes
from ipcore.proof.prover import prove
from service.cli.app import app
from tests.ipcore.proof.deceivers import ball, times


def run(answer: Any, points: Path) -> Result:  # noqa: ANN401 - JSON
    target = points.with_suffix(".json")
    target.write_bytes(orjson.dumps(answer))
    return CliRunner().invoke(app, ["verify", str(target), str(points)])


def fitted(shape: shapes.Shape, folder: Path, options: ipcore.FitOptions | None = None) -> tuple[dict[str, Any], Path]:
    points, normals = shape.sample(800)
    np.save(folder / "points.npy", np.hstack([points, normals]))
    return ipcore.fit(points, normals, options).to_dict(), folder / "points.npy"


@pytest.mark.parametrize("basis", ["monomial", "chebyshev"])
@pytest.mark.parametrize("make", [shapes.superellipse, shapes.torus], ids=["outline", "surface"])
def test_a_proof_is_verified(make: Callable[[], shapes.Shape], basis: str, tmp_path: Path) -> None:
    answer, points = fitted(make(), tmp_path, ipcore.FitOptions(basis=ipcore.Basis(basis)))
    assert answer["proof"]["regular"]
    done = run(answer, points)
    assert done.exit_code == 0, done.output
    assert f"has a point within {answer['proof']['within']:.6g}: verified on" in done.output
    assert "the zero set is smooth: verified on" in done.output


def test_a_distance_that_is_too_small_is_not_verified(tmp_path: Path) -> None:
    answer, points = fitted(shapes.ellipse(), tmp_path)
    answer["proof"]["within"] = 1e-4  # the points are 0.01 apart
    done = run(answer, points)
    assert done.exit_code == 1
    assert "not verified: there may be a zero too far from all points, at (" in done.stderr


@pytest.mark.parametrize("radius", [1e-3, 0.0])
def test_a_speck_is_found(radius: float, tmp_path: Path) -> None:
    answer, points = fitted(shapes.ellipse(), tmp_path)
    spoilt = times(shapes.ellipse().polynomial, ball(np.array([0.11, 0.07]), radius))
    done = run({**answer, "polynomial": spoilt.to_dict()}, points)
    assert done.exit_code == 1
    assert "at (0.1" in done.stderr


def test_a_zero_set_that_is_not_smooth_is_found(tmp_path: Path) -> None:
    data, _ = shapes.circle().sample(400)
    touching = times(shapes.circle().polynomial, ball(np.array([1.3, 0.0]), 0.3))
    points = np.vstack([data, 0.3 * data + np.array([1.3, 0.0])])
    bounded = ipcore.ImplicitPolynomial(
        touching.degree, touching.coefficients, touching.frame, np.array([[-1.5, -1.5], [2.0, 1.5]])
    )
    np.save(tmp_path / "points.npy", points)
    proof = prove(bounded, points)
    assert (proof.holds, proof.regular) == (True, False)
    claimed = {"within": proof.within, "holds": True, "regular": True}
    done = run({"polynomial": bounded.to_dict(), "proof": claimed}, tmp_path / "points.npy")
    assert done.exit_code == 1
    assert "has a point within" in done.output
    assert "not verified: the zero set may not be smooth, at (0.99" in done.stderr


CIRCLE = {
    "degree": 2,
    "basis": "monomial",
    "exponents": [[0, 0], [2, 0], [0, 2]],
    "coefficients": [-1, 1.0, 1.0],
    "frame": {"centre": [0.0, 0.0], "scale": 1.0},
    "bounds": [[-1.3, -1.3], [1.3, 1.3]],
}
PROOF = {"within": 0.1, "holds": True, "regular": True}


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        ([], "the answer: Input should be an object"),
        ({"polynomial": CIRCLE}, "has no proof"),
        ({"polynomial": CIRCLE, "proof": None}, "has no proof"),
        ({"polynomial": CIRCLE, "proof": {**PROOF, "holds": False}}, "claims nothing"),
        ({"proof": PROOF}, "polynomial: Field required"),
        *(
            ({"polynomial": CIRCLE, "proof": {**PROOF, name: value}}, f"proof.{name}")
            for name, value in [("holds", "no"), ("within", -1.0), ("within", None), ("within", [0.1]), ("regular", 1)]
        ),
        *(
            ({"polynomial": {**CIRCLE, name: value}, "proof": PROOF}, says)
            for name, value, says in [
                ("degree", 2.9, "polynomial.degree"),
                ("degree", "2", "polynomial.degree"),
                ("degree", 0, "polynomial.degree"),
                ("degree", 500, "at most 40 in 2 dimensions"),
                ("basis", "legendre", "polynomial.basis"),
                ("basis", None, "polynomial.basis"),
                ("exponents", [[0, 0], [2], [0, 2]], "exponents must be 2 numbers"),
                ("exponents", [[0, 0], [-1, 0], [0, 2]], "polynomial.exponents.1.0"),
                ("exponents", [[0, 0], [2, 1], [0, 2]], "sum is at most the degree"),
                ("exponents", [[0, 0], [2, 0], [2, 0]], "stand there twice"),
                ("exponents", [[0, 0], [True, False], [0, 2]], "polynomial.exponents.1.0"),
                ("exponents", [], "as many coefficients"),
                ("coefficients", [1.0, None, 1.0], "polynomial.coefficients.1"),
                ("frame", {"centre": [None, None], "scale": 1.0}, "polynomial.frame.centre.0"),
                ("frame", {"centre": [0.0, 0.0], "scale": 0.0}, "polynomial.frame.scale"),
                ("frame", None, "polynomial.frame"),
                ("frame", {"centre": [0.0, 0.0, 0.0], "scale": 1.0}, "exponents must be 3 numbers"),
                ("bounds", [[1.3, 1.3], [-1.3, -1.3]], "lower and an upper corner"),
                ("bounds", [[-1.3, -1.3], [-1.3, 1.3]], "lower and an upper corner"),
                ("bounds", [[-1.3, -1.3]], "polynomial.bounds"),
                ("bounds", None, "polynomial.bounds"),
            ]
        ),
    ],
)
def test_an_answer_without_a_claim_is_refused(answer: Any, says: str, tmp_path: Path) -> None:  # noqa: ANN401 - JSON
    np.save(tmp_path / "points.npy", shapes.circle().sample(10)[0])
    done = run(answer, tmp_path / "points.npy")
    assert done.exit_code == 2
    assert says in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_points_of_another_dimension_are_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", shapes.sphere().sample(10)[0])
    done = run({"polynomial": CIRCLE, "proof": PROOF}, tmp_path / "points.npy")
    assert done.exit_code == 2
    assert "the points have 3 coordinates" in done.stderr


def test_a_circle_is_verified(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", shapes.circle().sample(400)[0])
    assert run({"polynomial": CIRCLE, "proof": PROOF}, tmp_path / "points.npy").exit_code == 0


def test_what_is_not_json_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", shapes.circle().sample(10)[0])
    done = CliRunner().invoke(app, ["verify", str(tmp_path / "points.npy"), str(tmp_path / "points.npy")])
    assert done.exit_code == 2
    assert "error:" in done.stderr


def test_what_is_missing_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    monkeypatch.delitem(sys.modules, "service.cli.verification", raising=False)
    np.save(tmp_path / "points.npy", shapes.circle().sample(10)[0])
    done = run({}, tmp_path / "points.npy")
    assert done.exit_code == 2
    assert 'pip install "ipfit[verify]"' in done.stderr
