"""Point sets out: the stored npy as another file that `decode.read` reads again."""

from io import StringIO

import numpy as np
import orjson

from service.formats.points import decode

_COLUMNS = {2: "x,y,nx,ny", 3: "x,y,z,nx,ny,nz"}


def write(content: bytes, dimension: int, form: str) -> bytes:
    """Return a stored point set as a file of this format: `npy`, `csv` or `json`.

    Numbers are written so that reading them gives the same doubles.
    """
    points, normals = decode.split(content, dimension)
    if form == "npy":
        return content
    if form == "json":
        members = {"points": points} | ({} if normals is None else {"normals": normals})
        contiguous = {name: np.ascontiguousarray(array) for name, array in members.items()}
        return orjson.dumps(contiguous, option=orjson.OPT_SERIALIZE_NUMPY)
    table = points if normals is None else np.hstack([points, normals])
    names = _COLUMNS[dimension].split(",")[: table.shape[1]]
    text = StringIO()
    np.savetxt(text, table, fmt="%.17g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue().encode()
