"""The options of a fit, and which of them the caller gave."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import ipcore


@dataclass(frozen=True)
class RequestedOptions:
    """The options of one fit as the caller gave them. They are stored, echoed and compared in this form.

    Attributes
    ----------
    given
        Value by option name, `preset` among them, ready for JSON; defaults are not filled in.

    """

    given: Mapping[str, Any]

    @cached_property
    def complete(self) -> ipcore.FitOptions:
        """Return the library's options, with defaults filled in.

        They are checked when they are first asked for, and not when a row of the store is read: a fit that ended long
        ago stays readable though its options may not be allowed any more.

        Raises
        ------
        ipcore.InvalidOptionsError
            If a value is not allowed, or two contradict each other.

        >>> RequestedOptions({"preset": "paper", "t1": 0.02}).complete.t1
        0.02
        """
        return ipcore.FitOptions.of(**self.given)

    def with_max_degree(self, degree: int) -> Self:
        """Return the same options with this `max_degree`, as if the caller had given it."""
        return type(self)({**self.given, "max_degree": degree})
