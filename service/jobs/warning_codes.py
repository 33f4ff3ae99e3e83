"""The codes of warnings that answers may have."""

from typing import Any

import ipcore

# The code of warnings in results that were stored before warnings had codes.
UNCODED = "uncoded"
WARNING_CODES = (*map(str, ipcore.WarningCode), UNCODED)


def with_codes(warnings: list[Any]) -> list[Any]:
    """Return the warnings of a stored result, where those of early versions are plain texts, each with a code.

    >>> with_codes(["The degree is high."])
    [{'code': 'uncoded', 'message': 'The degree is high.'}]
    """
    return [{"code": UNCODED, "message": one} if isinstance(one, str) else one for one in warnings]
