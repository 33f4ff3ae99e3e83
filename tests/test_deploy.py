"""The files in deploy/ and .github/: by the schemas of those who read them, and held to what the service knows."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import kubernetes_validate
import pytest
import yaml
from prometheus_client import generate_latest
from prometheus_client.parser import text_string_to_metric_families

from service.settings import Settings
from service.telemetry.connections import ConnectionCounts
from service.telemetry.gauges import Gauges
from service.telemetry.metrics import Metrics
from tests.pages import DOCS, ROOT

DEPLOY = ROOT / "deploy"
MANIFESTS = sorted((DEPLOY / "kubernetes").glob("*.yaml"))
KUBERNETES = "1.34"
# Kinds that are not Kubernetes' own: kubectl reads the first itself, the others belong to KEDA.
OTHERS = {"Kustomization", "ScaledObject", "TriggerAuthentication"}
DOCUMENTS = [one for file in MANIFESTS for one in yaml.safe_load_all(file.read_text(encoding="utf-8"))]


def title(manifest: dict[str, Any]) -> str:
    return f"{manifest['kind']} {manifest.get('metadata', {}).get('name', '')}"


def check_schema(schema: str, *files: Path) -> None:
    command: list[str | Path] = [Path(sys.executable).parent / "check-jsonschema", "--builtin-schema", schema, *files]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)  # noqa: S603 - a program of this environment
    assert done.returncode == 0, done.stdout


def test_the_compose_file_is_one() -> None:
    check_schema("vendor.compose-spec", DEPLOY / "compose.yaml")


def test_the_workflows_are_workflows() -> None:
    files = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
    assert len(files) == 2
    check_schema("vendor.github-workflows", *files)


@pytest.mark.parametrize("manifest", [one for one in DOCUMENTS if one["kind"] not in OTHERS], ids=title)
def test_the_manifests_are_what_kubernetes_takes(manifest: dict[str, Any]) -> None:
    kubernetes_validate.validate(manifest, KUBERNETES, strict=True)


def test_a_manifest_with_an_unknown_field_would_be_noticed() -> None:
    service = next(one for one in DOCUMENTS if one["kind"] == "Service")
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(service | {"sepc": {}}, KUBERNETES, strict=True)


def test_no_service_gives_pods_a_variable_that_is_a_setting() -> None:
    """Kubernetes tells every pod of the Services around it: of one called `ipfit`, in IPFIT_PORT."""
    for one in DOCUMENTS:
        if one["kind"] == "Deployment":
            assert one["spec"]["template"]["spec"]["enableServiceLinks"] is False


def test_the_kustomization_lists_every_manifest() -> None:
    (own,) = [one for one in DOCUMENTS if one["kind"] == "Kustomization"]
    assert {*own["resources"], "kustomization.yaml"} == {file.name for file in MANIFESTS}


def test_what_others_refer_to_exists() -> None:
    named = {title(one) for one in DOCUMENTS}
    for one in DOCUMENTS:
        for target in re.findall(r"'scaleTargetRef': \{[^}]*'name': '([^']+)'", str(one)):
            assert f"Deployment {target}" in named
    components = {
        one["spec"]["template"]["metadata"]["labels"]["app.kubernetes.io/component"]
        for one in DOCUMENTS
        if one["kind"] == "Deployment"
    }
    selected = set(re.findall(r"'app.kubernetes.io/component': '([^']+)'", str(DOCUMENTS)))
    assert selected == components


@pytest.mark.parametrize("file", [*MANIFESTS, DEPLOY / "compose.yaml"], ids=lambda file: file.name)
def test_every_setting_in_them_is_one(file: Path) -> None:
    known = {f"IPFIT_{name.upper()}" for name in Settings.model_fields}
    assert set(re.findall(r"IPFIT_[A-Z_]+", file.read_text(encoding="utf-8"))) <= known


def test_every_image_that_is_used_is_one_that_the_dockerfile_makes() -> None:
    stages = re.findall(r"^FROM \S+ AS (\S+)$", (ROOT / "Dockerfile").read_text(encoding="utf-8"), re.MULTILINE)
    made = stages[-2:]  # the others are what these are made of
    assert made == ["s3", "plain"]  # without a target, the last one is built
    services = yaml.safe_load((DEPLOY / "compose.yaml").read_text(encoding="utf-8"))["services"].values()
    assert {one["build"]["target"] for one in services if "build" in one} == {"plain"}
    release = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8"))
    assert {one["target"] for one in release["jobs"]["image"]["strategy"]["matrix"]["include"]} == set(made)


def test_point_sets_in_an_s3_come_with_the_image_that_can_read_them() -> None:
    (settings,) = [one["data"] for one in DOCUMENTS if one["kind"] == "ConfigMap"]
    (own,) = [one for one in DOCUMENTS if one["kind"] == "Kustomization"]
    wants_s3 = settings["IPFIT_BLOBS_URL"].startswith("s3://")
    assert [image["newTag"].endswith("-s3") for image in own["images"]] == [wants_s3]


def exposed() -> set[str]:
    """Return the names of the samples of all metrics of this project."""
    metrics = Metrics()
    metrics.add(Gauges({}, list))
    metrics.add(ConnectionCounts(int, dict))
    families = text_string_to_metric_families(generate_latest(metrics.registry).decode())
    return {family.name for family in families if family.name.startswith("ipfit_")}


def test_the_dashboard_asks_for_metrics_that_there_are() -> None:
    board = (DEPLOY / "grafana" / "ipfit.json").read_text(encoding="utf-8")
    asked = {re.sub("_(bucket|sum|count|total)$", "", name) for name in re.findall(r"\bipfit_\w+", board)}
    assert asked <= {re.sub("_total$", "", name) for name in exposed()}
    assert len({panel["id"] for panel in json.loads(board)["panels"]}) == len(json.loads(board)["panels"])


def test_every_metric_has_its_row_in_the_documentation() -> None:
    page = (DOCS / "operation.md").read_text(encoding="utf-8")
    rows = set(re.findall(r"^\| `(ipfit_\w+)` \|", page, re.MULTILINE))
    assert {re.sub("_total$", "", name) for name in rows} == {re.sub("_total$", "", name) for name in exposed()}
