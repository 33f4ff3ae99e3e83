"""How large the file of a zero set will be, foretold from a coarse one."""

from collections.abc import Callable

import ipcore
from service.jobs.errors import TooLargeError

COARSE = 32  # grid points along the longest axis, for the prediction
# Resolutions up to which no file is large; they are not predicted.
HARMLESS = {2: 1024, 3: 96}


def check_size(
    extracted: Callable[[int | None], ipcore.ZeroSet],
    write: Callable[[ipcore.ZeroSet], bytes],
    resolution: int | None,
    dimension: int,
    most_bytes: int,
) -> None:
    """Refuse a file that would be too large, before its zero set is extracted.

    A curve has cells in proportion to the resolution, a surface to its square.

    Parameters
    ----------
    extracted, write
        Extracts the zero set at a resolution, and writes it as a file.
    resolution
        The one asked for; None, which the library bounds itself, is not checked.
    dimension
        2 or 3.
    most_bytes
        Bytes of the largest file.

    Raises
    ------
    TooLargeError
        If it would be larger.

    """
    if resolution is None or resolution <= HARMLESS[dimension]:
        return
    growth = (resolution / COARSE) ** (dimension - 1)
    predicted = len(write(extracted(COARSE))) * growth
    if predicted > most_bytes:
        raise TooLargeError(
            f"at resolution {resolution} the file would have about {predicted / 2**20:.0f} MiB; "
            f"{most_bytes / 2**20:.0f} are allowed here: ask for a lower resolution or smaller bounds",
            ("resolution",),
        )
