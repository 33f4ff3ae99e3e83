"""Fits posted over HTTP, and the values of their polynomials."""

from typing import Any

import httpx
import numpy as np

from tests.service.bodies import Array


def post(client: httpx.Client, body: object, query: str = "", **headers: str) -> httpx.Response:
    if isinstance(body, bytes):
        return client.post(f"/v1/fits?{query}", content=body, headers={"Content-Type": "application/x-npy"} | headers)
    return client.post(f"/v1/fits?{query}", json=body, headers=headers)


def fitted(client: httpx.Client, body: object, query: str = "") -> dict[str, Any]:
    answer = post(client, body, query)
    assert answer.status_code == 200, answer.text
    fit: dict[str, Any] = answer.json()
    assert fit["status"] == "successful", fit
    return fit


def values(fit: dict[str, Any], x: Array) -> Array:
    """f(x) = Σ coefficientᵢ · ((x − centre)/scale)^exponentᵢ, by the contract's sentence and numpy alone."""
    p = fit["polynomial"]
    u = (x - p["frame"]["centre"]) / p["frame"]["scale"]
    total: Array = (np.array(p["coefficients"]) * (u[:, None, :] ** np.array(p["exponents"])).prod(axis=2)).sum(axis=1)
    return total
