"""What clients ask for: requests, and how often each is sent."""

from dataclasses import dataclass
from random import Random
from urllib.parse import urlencode

import httpx
import numpy as np

from ipcore import shapes
from tests.service.bodies import npy

NPY = "application/x-npy"


@dataclass(frozen=True)
class Request:
    """A request that is sent again and again.

    Attributes
    ----------
    method, path, body
        As in HTTP; a body is an npy.
    share
        How often it is sent, relative to the others.

    """

    method: str
    path: str
    body: bytes = b""
    share: float = 1.0


def outlines(count: int = 500, share: float = 1.0) -> list[Request]:
    """Return fits of different closed outlines of so many points each."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    lobes = [(n, depth) for n in (2, 3, 4, 5) for depth in (0.05, 0.1, 0.15, 0.2, 0.25)]
    bodies = [npy((1.0 + depth * np.cos(n * angle + depth))[:, None] * circle) for n, depth in lobes]
    return [_fit(body, share / len(bodies)) for body in bodies]


def surfaces(count: int, share: float = 1.0) -> list[Request]:
    """Return fits of tori of so many oriented points each, of different thickness."""
    bodies = [npy(np.hstack(shapes.torus(minor=minor).sample(count))) for minor in (0.25, 0.35, 0.45)]
    return [_fit(body, share / len(bodies)) for body in bodies]


def mixed() -> list[Request]:
    """Return many small fits and a few large ones."""
    return [*outlines(500, 70.0), *surfaces(3000, 20.0), *surfaces(10_000, 8.0), *surfaces(100_000, 2.0)]


def meshes(url: str) -> list[Request]:
    """Fit surfaces at a server, and return requests for their meshes: so many that few are asked for twice."""
    with httpx.Client(base_url=url, timeout=60.0) as client:
        fits = [client.post("/v1/fits", content=one.body, headers={"Content-Type": NPY}) for one in surfaces(3000)]
    paths = [
        f"/v1/fits/{fit.raise_for_status().json()['id']}/mesh?{urlencode({'resolution': resolution})}"
        for fit in fits
        for resolution in range(32, 129)
    ]
    Random(0).shuffle(paths)  # noqa: S311 - no secret
    return [Request("GET", path) for path in paths]


def _fit(body: bytes, share: float) -> Request:
    return Request("POST", "/v1/fits", body, share)
