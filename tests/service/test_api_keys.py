"""API keys: whose fits these are, what each caller may ask for, and files that cannot be read."""

import subprocess
import tomllib
from pathlib import Path

import httpx
import pytest

from service.api_keys import ApiKeys, ApiKeysError
from tests.service.bodies import HALF_A_MINUTE, LONG, ellipse, npy
from tests.service.conftest import Start
from tests.service.running import COMMAND
from tests.service.test_problems import NPY, problem

POINTS = npy(ellipse(31))
QUICK = "/v1/fits?measure_zero_set=false&max_degree=2"
SLOW = f"/v1/fits?{HALF_A_MINUTE}"


def bearer(key: str, **more: str) -> dict[str, str]:
    return NPY | {"Authorization": f"Bearer {key}", **more}


def test_without_a_key_nothing_but_health_and_documents_can_be_had(start: Start, keys: tuple[Path, str, str]) -> None:
    file, ada, _ = keys
    server = start(API_KEYS=file, WORKERS=1)
    assert "2 API keys" in server.log
    for sent in ({}, {"Authorization": "Bearer ipfit_wrong"}, {"Authorization": f"Basic {ada}"}, bearer(ada.upper())):
        for method, path in (
            ("GET", "/v1/fits"),
            ("GET", "/v1/fits/x"),
            ("DELETE", "/v1/fits/x"),
            ("POST", "/v1/fits"),
        ):
            answer = server.client.request(method, path, headers=sent)
            problem(answer, 401, "unauthorized")
            assert answer.headers["WWW-Authenticate"] == "Bearer"
    for path in ("/livez", "/readyz", "/docs", "/openapi.json", "/problems"):
        assert server.client.get(path).is_success
    assert server.client.post(QUICK, content=POINTS, headers=bearer(ada)).json()["status"] == "successful"
    assert ada not in server.log


def test_a_fit_belongs_to_the_key_that_sent_it(start: Start, keys: tuple[Path, str, str]) -> None:
    file, ada, bob = keys
    client = start(API_KEYS=file, WORKERS=1).client
    sent = bearer(ada, **{"Idempotency-Key": '"same"'})
    fit = client.post(QUICK, content=POINTS, headers=sent)
    where = fit.headers["Location"]
    mesh_tag = client.get(f"{where}/mesh", headers=bearer(ada)).headers["ETag"]
    for path in (where, f"{where}/mesh", f"{where}/points"):
        assert client.get(path, headers=bearer(ada)).is_success
        problem(client.get(path, headers=bearer(bob)), 404, "fit-not-found")
        problem(client.get(path, headers=bearer(bob, **{"If-None-Match": mesh_tag})), 404, "fit-not-found")
    for query in ("", "?purge=true"):
        problem(client.delete(f"{where}{query}", headers=bearer(bob)), 404, "fit-not-found")
    other = client.post(QUICK, content=npy(ellipse(32)), headers=bearer(bob, **{"Idempotency-Key": '"same"'}))
    assert other.status_code == 200  # not the fit of the other key, and no 422
    assert "Idempotency-Replayed" not in other.headers
    assert client.post(QUICK, content=POINTS, headers=sent).headers["Idempotency-Replayed"] == "true"
    for key, own in ((ada, fit), (bob, other)):
        listed = client.get("/v1/fits", headers=bearer(key)).json()["fits"]
        assert [one["id"] for one in listed] == [own.json()["id"]]


def test_quotas_are_told_and_kept(start: Start, keys: tuple[Path, str, str]) -> None:
    file, ada, bob = keys
    client = start(API_KEYS=file, WORKERS=1, SHORT_WORKERS=0).client
    at_once = bearer(bob, Prefer="respond-async")
    answers = [client.post(SLOW, content=LONG, headers=at_once) for _ in range(4)]
    assert [answer.status_code for answer in answers] == [202, 202, 202, 429]
    assert answers[0].headers["RateLimit-Policy"] == '"waiting";q=2, "hourly";q=3;w=3600'
    assert answers[0].headers["RateLimit"].startswith('"waiting";r=1;t=1, "hourly";r=2;t=')
    told = problem(answers[3], 429, "quota-exceeded")
    assert "2 fits of yours wait" in told["detail"] or "3 fits of yours were accepted within an hour" in told["detail"]
    assert int(answers[3].headers["Retry-After"]) >= 1
    for answer in answers[:3]:
        client.delete(answer.headers["Location"], headers=bearer(bob))
    assert client.delete(f"{answers[0].headers['Location']}?purge=true", headers=bearer(bob)).status_code == 204
    spent = client.post(QUICK, content=POINTS, headers=bearer(bob))
    assert "3 fits of yours were accepted within an hour" in problem(spent, 429, "quota-exceeded")["detail"]
    assert int(spent.headers["Retry-After"]) > 3000
    assert client.post(QUICK, content=POINTS, headers=bearer(ada)).json()["status"] == "successful"


def test_one_address_cannot_fill_the_queue(start: Start) -> None:
    server = start(QUEUE_LIMIT=4, WORKERS=1)
    assert "everybody who reaches this server may use it" in server.log
    at_once = NPY | {"Prefer": "respond-async"}
    answers = [server.client.post(SLOW, content=LONG, headers=at_once) for _ in range(4)]
    assert [answer.status_code for answer in answers] == [202, 202, 202, 429]  # one runs, and two wait
    other = httpx.Client(base_url=server.url, transport=httpx.HTTPTransport(local_address="127.0.0.7"), timeout=60.0)
    with other:
        assert other.post(SLOW, content=LONG, headers=at_once).status_code == 202


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[ada", "keys.toml: "),
        ("ada = 3", "'ada' is not the name of a table"),
        ('["a b"]\nsha256 = []', "'a b' is not the name"),
        ("[ada]\nsha256 = []", "ada: sha256 must be a list"),
        ('[ada]\nsha256 = ["abc"]', "ada: sha256 must be a list of hashes of 64"),
        (f'[ada]\nsha256 = ["{"a" * 64}"]\nhourly = 0', "ada: hourly must be a whole number"),
        (f'[ada]\nsha256 = ["{"a" * 64}"]\ndaily = 1', "ada: daily is unknown"),
        (
            f'[ada]\nsha256 = ["{"a" * 64}"]\n[bob]\nsha256 = ["{"a" * 64}"]',
            "bob: this sha256 stands in the file twice",
        ),
    ],
)
def test_a_file_that_is_wrong_says_where(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "keys.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ApiKeysError, match=".*".join(message.split("…"))) as wrong:
        ApiKeys.read(file)
    assert message in str(wrong.value)


def test_the_command_makes_a_key_and_its_entry(tmp_path: Path) -> None:
    done = subprocess.run([COMMAND, "key", "ada"], capture_output=True, text=True, timeout=60, check=True)  # noqa: S603 - ours
    (tmp_path / "keys.toml").write_text(done.stdout, encoding="utf-8")
    key = done.stdout.splitlines()[0].rpartition(" ")[2]
    keys = ApiKeys.read(tmp_path / "keys.toml")
    caller = keys.caller(key)
    assert caller is not None
    assert caller.owner == "ada"
    assert keys.caller(key[:-1]) is None
    assert list(tomllib.loads(done.stdout)) == ["ada"]
    wrong = subprocess.run([COMMAND, "key", "a b"], capture_output=True, text=True, timeout=60, check=False)  # noqa: S603 - ours
    assert (wrong.returncode, "a name has 1 to 64" in wrong.stderr) == (2, True)


def test_a_server_whose_keys_cannot_be_read_does_not_start(tmp_path: Path) -> None:
    told = {"IPFIT_API_KEYS": str(tmp_path / "none.toml"), "IPFIT_DATA_DIR": str(tmp_path / "data"), "IPFIT_PORT": "0"}
    done = subprocess.run([COMMAND, "serve"], env=told, capture_output=True, text=True, timeout=60, check=False)  # noqa: S603 - ours
    assert done.returncode != 0
    assert "none.toml" in done.stderr
