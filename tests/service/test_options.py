"""The options: the same in the library, over HTTP, on the command line and in docs/options.md; a wrong one is named."""

import json
from dataclasses import fields
from enum import StrEnum
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import orjson
import pytest
from typer.testing import CliRunner

import ipcore
from ipcore import shapes
from service.cli.app import app
from service.cli.option_texts import table
from service.options import FitOptions, requested
from tests.service.bodies import ellipse, npy, torus

DOCUMENT = Path(__file__).parents[2] / "docs" / "options.md"
OWN = [name for name in FitOptions.model_fields if name != "preset"]
# For each option: values out of its range, and of no meaning to it.
WRONG: dict[str, list[Any]] = {
    "preset": ["papers", 1],
    "max_degree": [0, 41, 2.5, "many"],
    "constraints": ["4l", 3],
    "layer_distance": [0.0, 0.31, "thin"],
    "gradient_weight": [0.0, 101.0, "light"],
    "criterion": ["aic", True],
    "t1": [-0.01, "close"],
    "t2": [1.01, -1.01, "smooth"],
    "granularity": ["column", 1],
    "factor": ["cholesky", 2],
    "collinear": ["forget", 0],
    "collinear_tol": [-1.0, 2.0, "tight"],
    "ridge": ["partial", 1],
    "ridge_matrix": ["laplace", 1],
    "ridge_strength": [0.0, 2e6, "strong"],
    "signs": ["maybe", 2],
    "geometric": ["maybe", 2],
    "angle_weight": [0.0, 1.1, "light"],
    "robust": ["maybe", 2],
    "neighbours": [2, 101, 7.5, "some"],
    "basis": ["bernstein", 1],
    "measure_zero_set": ["maybe", 2],
}
# Values that are allowed and are not the default, with what they need beside them.
RIGHT: list[dict[str, Any]] = [
    {"preset": "paper"},
    {"preset": "paper", "ridge_matrix": "identity", "max_degree": 5},
    *({"constraints": family} for family in ("5l", "3l+gradient", "gradient-one", "min-max", "min-var", "taubin")),
    {"constraints": "gradient-one", "gradient_weight": 0.1},
    {"layer_distance": 0.1, "geometric": False},
    *({"criterion": criterion, "max_degree": 6} for criterion in ("gcv", "bic", "loo", "none")),
    {"t1": 0.001, "t2": 0.9},
    {"granularity": "monomial"},
    {"factor": "block"},
    {"factor": "moments"},
    {"factor": "tsqr", "constraints": "gradient-one"},
    {"factor": "gram-schmidt", "max_degree": 4},
    {"collinear": "drop", "collinear_tol": 1e-8},
    {"ridge": "full", "ridge_strength": 1e-3, "ridge_matrix": "identity"},
    {"ridge": "selective", "collinear": "ridge"},
    {"signs": False},
    {"signs": True, "geometric": False},
    {"signs": False, "geometric": False},
    {"angle_weight": 0.01},
    {"robust": True},
    {"neighbours": 8},
    {"basis": "chebyshev"},
    {"measure_zero_set": False},
]
CONTRADICTIONS: list[tuple[dict[str, Any], str]] = [
    ({"constraints": "taubin", "ridge": "full"}, "ridge"),
    ({"constraints": "taubin", "criterion": "gcv"}, "criterion"),
    ({"collinear": "ridge"}, "collinear"),
    ({"factor": "moments", "constraints": "gradient-one"}, "factor"),
    ({"factor": "tsqr", "criterion": "loo"}, "factor"),
    ({"geometric": True, "constraints": "5l"}, "geometric"),
    ({"signs": True, "criterion": "gcv"}, "signs"),
    ({"robust": True, "ridge": "full"}, "robust"),
]


def test_every_option_of_the_library_is_one_of_the_service_with_the_same_default() -> None:
    library = {field.name: field.default for field in fields(ipcore.FitOptions)}
    service = {name: FitOptions.model_fields[name].default for name in OWN}
    assert service == library


@pytest.mark.parametrize("name", OWN)
def test_words_are_those_of_the_library(name: str) -> None:
    default = getattr(ipcore.FitOptions(), name)
    kind = ipcore.Collinear if name == "collinear" else type(default)
    if issubclass(kind, StrEnum):
        schema = FitOptions.model_json_schema()["properties"][name]
        assert schema.get("anyOf", [schema])[0]["enum"] == [str(member) for member in kind]


def test_what_the_caller_gave_stays_as_it_was_given() -> None:
    body: dict[str, Any] = {"preset": "paper", "t1": 0.5, "max_degree": 4}
    options = requested(body, {"t1": 0.25})
    assert json.loads(orjson.dumps(options.given)) == {"preset": "paper", "t1": 0.25, "max_degree": 4}
    assert options.complete == ipcore.FitOptions.of("paper", t1=0.25, max_degree=4)


def test_every_option_has_its_wrong_values_here() -> None:
    assert set(WRONG) == set(FitOptions.model_fields)
    assert {name for options in RIGHT for name in options} == set(FitOptions.model_fields)


@pytest.mark.parametrize(("name", "value"), [(name, value) for name in WRONG for value in WRONG[name]])
def test_a_wrong_value_in_the_body_is_named(client: httpx.Client, name: str, value: object) -> None:
    answer = client.post("/v1/fits", json={"points": ellipse().tolist(), "options": {name: value}})
    assert answer.status_code == 422, answer.text
    assert [error["pointer"] for error in answer.json()["errors"]] == [f"/options/{name}"]


@pytest.mark.parametrize("name", list(WRONG))
def test_a_wrong_value_in_the_query_is_named(client: httpx.Client, name: str) -> None:
    answer = client.post(
        "/v1/fits",
        params={name: json.dumps(WRONG[name][0]).strip('"')},
        content=npy(ellipse()),
        headers={"Content-Type": "application/x-npy"},
    )
    assert answer.status_code == 422, answer.text
    assert name in answer.json()["errors"][0].get("parameter", "") + answer.json()["errors"][0].get("pointer", "")


@pytest.mark.parametrize(("options", "named"), CONTRADICTIONS)
def test_a_contradiction_is_refused_and_named(client: httpx.Client, options: dict[str, Any], named: str) -> None:
    answer = client.post("/v1/fits", json={"points": ellipse().tolist(), "options": options})
    assert answer.status_code == 422, answer.text
    assert [error["pointer"] for error in answer.json()["errors"]] == [f"/options/{named}"]


@pytest.mark.parametrize("options", RIGHT, ids=str)
@pytest.mark.parametrize("points", [ellipse(), torus()], ids=["ellipse", "torus"])
def test_every_option_reaches_the_fit(client: httpx.Client, options: dict[str, Any], points: Any) -> None:  # noqa: ANN401 - an array
    query = {name: str(value).lower() for name, value in ({"max_degree": 5} | options).items()}
    answer = client.post(
        "/v1/fits",
        params=query,
        content=npy(points),
        headers={"Content-Type": "application/x-npy", "Prefer": "wait=60"},
    )
    assert answer.status_code == 200, answer.text
    fit = answer.json()
    assert fit["status"] == "successful", fit["problem"]
    own = {name: value for name, value in options.items() if name != "preset"}
    assert fit["options"] | own == fit["options"]
    assert fit["options"]["granularity"] == (
        "monomial" if "paper" in options.values() else options.get("granularity", "form")
    )


@pytest.mark.parametrize("options", RIGHT, ids=str)
def test_every_option_is_one_of_the_command(tmp_path: Path, options: dict[str, Any]) -> None:
    np.save(tmp_path / "circle.npy", np.hstack(shapes.circle().sample(80)))
    told = [part for name, value in options.items() for part in flag(name, value)]
    target = tmp_path / "fit.json"
    done = CliRunner().invoke(app, ["fit", str(tmp_path / "circle.npy"), "--output", str(target), *told])
    assert done.exit_code == 0, done.output
    own = {name: value for name, value in options.items() if name != "preset"}
    written = json.loads(target.read_bytes())["options"]
    assert written | own == written


def flag(name: str, value: object) -> list[str]:
    dashed = name.replace("_", "-")
    if isinstance(value, bool):
        return [f"--{dashed}" if value else f"--no-{dashed}"]
    return [f"--{dashed}", str(value)]


def test_a_contradiction_is_named_on_the_command_line(tmp_path: Path) -> None:
    np.save(tmp_path / "circle.npy", np.hstack(shapes.circle().sample(80)))
    done = CliRunner().invoke(app, ["fit", str(tmp_path / "circle.npy"), "--constraints", "taubin", "--ridge", "full"])
    assert done.exit_code == 2
    assert "ridge needs a right-hand side" in done.output


def test_the_document_has_the_table_of_options() -> None:
    assert table() in DOCUMENT.read_text(encoding="utf-8")


def test_the_command_prints_the_table() -> None:
    assert CliRunner().invoke(app, ["options"]).output.strip() == table()


@pytest.mark.parametrize(
    "names",
    [[f"a{i}" for i in range(51)], [f"a{i}" for i in range(100_000)], ["a" * 65], ["max_degree", "b" * 1_000_000]],
    ids=["51", "100,000", "65 characters", "a million characters"],
)
def test_masses_of_options_are_refused_in_few_words(client: httpx.Client, names: list[str]) -> None:
    body = {"points": [[0, 0], [1, 0], [0, 1], [1, 1]], "options": dict.fromkeys(names, 3)}
    answer = client.post("/v1/fits", json=body)
    assert answer.status_code == 422
    assert len(answer.content) < 1000
    assert answer.json()["errors"][0]["pointer"].startswith("/options")
