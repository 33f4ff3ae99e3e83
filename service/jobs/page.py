"""A page of a list of fits."""

import base64
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Self

from service.jobs.errors import InvalidInputError
from service.jobs.fit import Fit, FitStatus

# A time with its zone, and an id; no other text is shown to a database.
_CURSOR = re.compile(r"([0-9T:.-]{19,26}\+00:00) ([0-9a-f]{1,32})")


@dataclass(frozen=True)
class Page:
    """A page of fits, the newest first.

    Attributes
    ----------
    limit
        Most fits on it.
    status
        Of the fits; None means all.
    before
        Time and id of the last fit of the page before; None for the first page.

    """

    limit: int
    status: FitStatus | None = None
    before: tuple[datetime, str] | None = None

    @classmethod
    def of(cls, limit: int, status: str | None, cursor: str | None) -> Self:
        """Return the page that begins at a cursor.

        Raises
        ------
        InvalidInputError
            If the cursor is none that `cursor` made.

        """
        return cls(limit, None if status is None else FitStatus(status), None if cursor is None else _parsed(cursor))

    @staticmethod
    def cursor(last: Fit) -> str:
        """Return the cursor of the page that follows a fit.

        >>> from service.jobs.fit import PointSetRef
        >>> from service.jobs.requested_options import RequestedOptions
        >>> when = datetime.fromisoformat("2026-11-30T08:00:00.000001+00:00")
        >>> fit = Fit("ab", FitStatus.ACCEPTED, PointSetRef("", 3, 9), RequestedOptions({}), when)
        >>> Page.of(10, None, Page.cursor(fit)).before == (when, "ab")
        True
        """
        return base64.urlsafe_b64encode(f"{last.created.isoformat()} {last.id}".encode()).decode().rstrip("=")


def _parsed(cursor: str) -> tuple[datetime, str]:
    try:
        text = base64.b64decode(cursor + "=" * (-len(cursor) % 4), altchars=b"-_", validate=True).decode("ascii")
        found = _CURSOR.fullmatch(text)
        created, fit_id = found.groups() if found is not None else ("", "")
        return datetime.fromisoformat(created).astimezone(UTC), fit_id
    except (ValueError, OverflowError) as error:
        raise InvalidInputError("cursor must be the one in `next` of the page before", ("cursor",)) from error
