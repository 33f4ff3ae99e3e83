"""Makes a fit and takes its mesh by the client that openapi-python-client generates."""

import json
import sys
from math import sqrt

from ipfit_client import AuthenticatedClient
from ipfit_client.api.fits import create, mesh, read
from ipfit_client.models import FitOptions, FitRequest, FitResource, MeshFormatType0, Polynomial, Problem
from ipfit_client.types import File

KEY = "ipfit_any"  # the server of this test wants none
S = sqrt(1 / 3)
POINTS = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
POINTS += [[x, y, z] for x in (S, -S) for y in (S, -S) for z in (S, -S)]

client = AuthenticatedClient(base_url=sys.argv[1], token=KEY, raise_on_unexpected_status=True)
body = FitRequest(points=POINTS, normals=POINTS, options=FitOptions(max_degree=2))
fit = create.sync(client=client, body=body, prefer="wait=60")
assert isinstance(fit, FitResource), fit
assert isinstance(fit.polynomial, Polynomial), fit
file = mesh.sync(fit.id, client=client, format_=MeshFormatType0.PLY, resolution=24)
assert isinstance(file, File), file
missing = read.sync("0" * 32, client=client)
assert isinstance(missing, Problem), missing

print(
    json.dumps(
        {
            "status": fit.status.value,
            "degree": fit.polynomial.degree,
            "mesh": file.payload.read(3).decode(),
            "missing": missing.type_,
        }
    )
)
