"""The writers of zero sets, by format."""

from collections.abc import Callable
from importlib import import_module
from typing import cast

import ipcore
from service.jobs.media_types import ZERO_SET_FORMATS

Writer = Callable[[ipcore.ZeroSet], bytes]


def _writer(name: str) -> Writer:
    """Return the function `write` of the module of this package that is named like the format."""
    return cast("Writer", import_module(f"{__package__}.{name}").write)


WRITERS: dict[str, Writer] = {known.name: _writer(known.name) for known in ZERO_SET_FORMATS}
