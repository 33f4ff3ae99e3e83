"""What runs inside a worker: a fit, from the stored point set to the answer's JSON."""

from dataclasses import asdict
from io import BytesIO
from typing import Any

import numpy as np
import orjson

import ipcore
from service.jobs.errors import NotReadyError
from service.jobs.ports import BlobStore
from service.workers.progress import report


def fit(blobs: BlobStore, key: str, dimension: int, options: dict[str, Any]) -> bytes:
    """Fit a stored point set and return the answer as JSON; every degree is reported as it is made.

    Raises
    ------
    NotReadyError
        If the point set cannot be read, which is no fault of the fit.

    """
    try:
        content = blobs.get(key)
    except Exception as error:  # whatever the file system raises, and not all of it can be pickled
        raise NotReadyError(f"the point set cannot be read: {type(error).__name__}: {error}") from error
    table = np.load(BytesIO(content), allow_pickle=False)
    normals = table[:, dimension:] if table.shape[1] > dimension else None
    chosen = ipcore.FitOptions.of(**options)
    result = ipcore.fit(table[:, :dimension], normals, chosen, progress=lambda step: report(asdict(step)))
    return orjson.dumps(result.to_dict())
