"""The OpenAPI document is committed, up to date and complete, and its examples work."""

import json
import subprocess
from collections.abc import Iterator
from math import comb
from pathlib import Path
from typing import Any

import httpx
import jsonschema_rs
import pytest

from ipcore.proof.prover import MOST_UNCLEARED
from service.bootstrap.application import application
from service.jobs.bounds import MOST_COEFFICIENTS
from service.settings import Settings
from tests.service.running import COMMAND

COMMITTED = Path(__file__).parents[2] / "openapi" / "openapi.json"
DOCUMENT: dict[str, Any] = application(Settings()).openapi()
EXAMPLES = DOCUMENT["components"]["schemas"]["FitRequest"]["examples"]


def nodes(node: object, at: str = "#") -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield every object of a document and its place."""
    if isinstance(node, dict):
        yield at, node
    for key, value in node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ():
        yield from nodes(value, f"{at}/{key}")


def resolved(response: dict[str, Any]) -> dict[str, Any]:
    """Return what a response is: those that all operations have are named and described once."""
    name = response.get("$ref", "").removeprefix("#/components/responses/")
    found: dict[str, Any] = DOCUMENT["components"]["responses"][name] if name else response
    return found


def test_the_committed_document_is_the_running_one(client: httpx.Client) -> None:
    served = client.get("/openapi.json").json()
    assert json.loads(COMMITTED.read_text(encoding="utf-8")) == served, "make openapi"
    assert served == DOCUMENT


def test_the_command_prints_the_committed_bytes(tmp_path: Path) -> None:
    printed = subprocess.run([COMMAND, "openapi"], cwd=tmp_path, capture_output=True, check=True)  # noqa: S603 - ours
    assert printed.stdout == COMMITTED.read_bytes()
    assert not list(tmp_path.iterdir())


def test_every_reference_leads_somewhere() -> None:
    for at, node in nodes(DOCUMENT):
        assert "$defs" not in node, at
        if isinstance(reference := node.get("$ref"), str):
            target = DOCUMENT
            for part in reference.removeprefix("#/").split("/"):
                assert part in target, (at, reference)
                target = target[part]


def test_everything_has_a_description() -> None:
    for name, schema in DOCUMENT["components"]["schemas"].items():
        assert schema.get("description"), name
        for member, value in schema.get("properties", {}).items():
            assert value.get("description"), (name, member)
    for path, operations in DOCUMENT["paths"].items():
        for method, operation in operations.items():
            assert operation["description"], (method, path)
            assert operation["summary"], (method, path)
            for parameter in operation.get("parameters", ()):
                assert parameter.get("description"), (method, path, parameter["name"])
            for status, response in operation["responses"].items():
                assert resolved(response)["description"], (method, path, status)


def test_errors_are_described_as_problems() -> None:
    for at, node in nodes(DOCUMENT["paths"]):
        if (
            "/callbacks/" not in at
            and at.split("/")[-2:-1] == ["responses"]
            and not at.endswith(("200", "202", "204", "206", "304"))
        ):
            assert list(resolved(node)["content"]) == ["application/problem+json"], at


def test_no_fit_has_more_coefficients_than_the_document_allows() -> None:
    options = DOCUMENT["components"]["schemas"]["FitOptions"]["properties"]["max_degree"]["anyOf"][0]
    assert max(comb(options["maximum"] + 2, 2), comb(20 + 3, 3)) == MOST_COEFFICIENTS


def test_no_proof_tells_more_places_than_the_document_allows() -> None:
    assert DOCUMENT["components"]["schemas"]["Proof"]["properties"]["uncleared"]["maxItems"] == MOST_UNCLEARED


def test_a_client_that_sends_defaults_sends_no_options() -> None:
    schemas = DOCUMENT["components"]["schemas"]
    assert not [name for name, option in schemas["FitOptions"]["properties"].items() if "default" in option]
    for parameter in DOCUMENT["paths"]["/v1/fits"]["post"]["parameters"]:
        assert "default" not in parameter["schema"] or parameter["name"] == "missing"


def test_it_is_openapi_3_1() -> None:
    assert DOCUMENT["openapi"].startswith("3.1.")
    for name in DOCUMENT["components"]["schemas"]:
        jsonschema_rs.Draft202012Validator({"$ref": f"#/components/schemas/{name}", **DOCUMENT})


def test_the_sentence_that_explains_the_coefficients_is_there() -> None:
    sentence = "f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ, negative inside"
    assert sentence in DOCUMENT["info"]["description"]
    assert sentence in DOCUMENT["components"]["schemas"]["Polynomial"]["description"]


@pytest.mark.parametrize("example", EXAMPLES)
def test_every_example_works_and_its_answer_is_as_described(client: httpx.Client, example: dict[str, Any]) -> None:
    answer = client.post("/v1/fits", json=example)
    assert answer.status_code == 200, answer.text
    fit = answer.json()
    assert fit["status"] == "successful"
    jsonschema_rs.Draft202012Validator({"$ref": "#/components/schemas/FitResource", **DOCUMENT}).validate(fit)
    assert fit["stop_reason"] == "criterion-met", fit
    assert (client.get(f"/v1/fits/{fit['id']}/mesh")).status_code == 200
