"""Listing fits, and taking their points back."""

import io

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.service.bodies import ellipse, npy, sphere
from tests.service.conftest import Start
from tests.service.running import Server
from tests.service.test_problems import problem


def test_fits_are_listed_in_pages_the_newest_first(start: Start) -> None:
    server = start(WORKERS=1)
    made = [server.fit(npy(ellipse(30 + i)), "measure_zero_set=false")["id"] for i in range(5)]
    failed = server.fit(npy(sphere()), "factor=block&constraints=min-var&max_degree=1&t1=0", prefer="respond-async")
    server.client.delete(f"/v1/fits/{failed['id']}")
    page, seen = "/v1/fits?limit=2", list[str]()
    while page:
        answer = server.client.get(page)
        listed = answer.json()
        assert len(listed["fits"]) <= 2
        assert all("polynomial" not in one and "steps" not in one for one in listed["fits"])
        seen += [one["id"] for one in listed["fits"]]
        assert (answer.links.get("next", {}).get("url") or None) == listed["next"]
        page = listed["next"]
        if len(seen) == 2:  # what comes meanwhile does not move the pages that follow
            server.fit(npy(ellipse(50)), "measure_zero_set=false")
    assert seen == [failed["id"], *reversed(made)]
    known = server.client.get("/v1/fits?limit=3")
    assert server.client.get("/v1/fits?limit=3", headers={"If-None-Match": known.headers["ETag"]}).status_code == 304


def test_fits_of_one_status(shared: Server) -> None:
    shared.fit(npy(ellipse(33)))
    for status in ("successful", "running"):
        listed = shared.client.get(f"/v1/fits?status={status}&limit=100").json()["fits"]
        assert {one["status"] for one in listed} <= {status}
    assert len(shared.client.get("/v1/fits?status=successful&limit=1").json()["fits"]) == 1


@pytest.mark.parametrize("query", ["limit=0", "limit=101", "status=done", "cursor=x", "cursor=AAAA", "cursor=MSAy"])
def test_a_list_that_cannot_be_made(client: httpx.Client, query: str) -> None:
    answer = client.get(f"/v1/fits?{query}")
    assert answer.status_code == 422, answer.text
    assert problem(answer, 422, answer.json()["code"])["errors"][0]["parameter"] == query.partition("=")[0]


@pytest.mark.parametrize("table", [ellipse(40), sphere()], ids=["2D", "3D with normals"])
def test_the_points_come_back_as_they_were_sent(shared: Server, table: NDArray[np.float64]) -> None:
    fit = shared.fit(npy(table), "measure_zero_set=false&max_degree=2")
    where, dimension = f"/v1/fits/{fit['id']}/points", fit["dimension"]
    stored = np.load(io.BytesIO(shared.client.get(where).content))
    np.testing.assert_allclose(stored, table, rtol=1e-15)
    as_json = shared.client.get(where, headers={"Accept": "application/json"}).json()
    np.testing.assert_array_equal(as_json["points"], stored[:, :dimension])
    assert ("normals" in as_json) == (stored.shape[1] > dimension)
    as_csv = shared.client.get(f"{where}?format=csv")
    assert as_csv.headers["Content-Type"].startswith("text/csv")
    np.testing.assert_array_equal(np.loadtxt(io.StringIO(as_csv.text), delimiter=",", skiprows=1), stored)
    for answer, kind in ((as_csv, "text/csv"), (shared.client.get(where), "application/x-npy")):
        again = shared.client.post(
            "/v1/fits?max_degree=2", content=answer.content, headers={"Content-Type": kind}
        ).json()
        assert again["polynomial"]["coefficients"] == pytest.approx(fit["polynomial"]["coefficients"], abs=1e-9)


def test_points_that_are_known_or_cannot_be_had(shared: Server) -> None:
    where = f"/v1/fits/{shared.fit(npy(ellipse(45)))['id']}/points"
    etag = shared.client.get(where).headers["ETag"]
    assert shared.client.get(where, headers={"If-None-Match": etag}).status_code == 304
    assert shared.client.get(f"{where}?format=csv", headers={"If-None-Match": etag}).status_code == 200
    problem(shared.client.get(where, headers={"Accept": "image/png"}), 406, "not-acceptable")
    problem(shared.client.get("/v1/fits/none/points"), 404, "fit-not-found")
