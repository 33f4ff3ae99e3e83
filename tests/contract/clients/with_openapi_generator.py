"""Makes a fit and takes its mesh by the Python client that openapi-generator generates."""

import json
import sys
from math import sqrt

from openapi_client import ApiClient, Configuration, FitOptions, FitRequest, FitsApi, Normals, Points
from openapi_client.exceptions import NotFoundException

KEY = "ipfit_any"  # the server of this test wants none
S = sqrt(1 / 3)
POINTS = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
POINTS += [[x, y, z] for x in (S, -S) for y in (S, -S) for z in (S, -S)]

fits = FitsApi(ApiClient(Configuration(host=sys.argv[1], access_token=KEY)))
body = FitRequest(points=Points(POINTS), normals=Normals(POINTS), options=FitOptions(max_degree=2))
fit = fits.create(body, prefer="wait=60")
assert fit.polynomial is not None, fit
file = fits.mesh(fit.id, format="ply", resolution=24)
try:
    fits.read("0" * 32)
except NotFoundException as error:
    missing = error.data.type if error.data else None

print(
    json.dumps({"status": fit.status, "degree": fit.polynomial.degree, "mesh": file[:3].decode(), "missing": missing})
)
