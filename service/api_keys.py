"""API keys: names, hashes and quotas in a TOML file. The keys themselves are kept by nobody but their callers."""

import hashlib
import re
import secrets
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from service.jobs.caller import Caller, Quota

KEY_PREFIX = "ipfit_"  # by which people, and scanners for lost secrets, recognise a key
_NAME = re.compile(r"[A-Za-z0-9._-]{1,64}")
_HASH = re.compile(r"[0-9a-f]{64}")
_QUOTAS = ("waiting", "hourly")


class ApiKeysError(Exception):
    """The file of API keys cannot be read."""


@dataclass(frozen=True)
class ApiKeys:
    """The callers by the SHA-256 of their keys.

    A key has 256 random bits, so that its hash needs neither salt nor many rounds: nobody can try all keys.
    """

    callers: dict[str, Caller]

    @classmethod
    def read(cls, file: Path) -> Self:
        """Return the keys in a file.

        Raises
        ------
        ApiKeysError
            If it cannot be read, or an entry is not as `entry` writes it; the message says what and where.

        """
        try:
            tables = tomllib.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ApiKeysError(f"{file}: {error}") from error
        callers: dict[str, Caller] = {}
        for name, table in tables.items():
            for digest in _hashes(name, table):
                if digest in callers:
                    raise ApiKeysError(f"{name}: this sha256 stands in the file twice")
                callers[digest] = Caller(name, name, Quota(**{one: _count(name, table, one) for one in _QUOTAS}))
        return cls(callers)

    def caller(self, key: str) -> Caller | None:
        """Return the caller who has a key, or None."""
        return self.callers.get(hashlib.sha256(key.encode()).hexdigest())


def new_key(name: str) -> tuple[str, str]:
    """Return a new key, and its entry for the file.

    Raises
    ------
    ApiKeysError
        If the name has other characters than letters, digits, `.`, `_` and `-`, or more than 64.

    """
    if not _NAME.fullmatch(name):
        raise ApiKeysError(f"{name[:80]!r}: a name has 1 to 64 letters, digits, dots, hyphens and underscores")
    key = KEY_PREFIX + secrets.token_urlsafe(32)
    return key, f'["{name}"]\nsha256 = ["{hashlib.sha256(key.encode()).hexdigest()}"]\n'


def _hashes(name: str, table: Any) -> list[str]:  # noqa: ANN401 - whatever stands in the file
    """Return the hashes of an entry: several, so that a key can be replaced while the old one still works."""
    if not _NAME.fullmatch(name) or not isinstance(table, dict):
        raise ApiKeysError(f"{name[:80]!r} is not the name of a table with a caller's keys")
    if unknown := sorted(table.keys() - {"sha256", *_QUOTAS}):
        raise ApiKeysError(f"{name}: {unknown[0]} is unknown; known are sha256, {', '.join(_QUOTAS)}")
    hashes = table.get("sha256")
    if (
        not isinstance(hashes, list)
        or not hashes
        or not all(isinstance(one, str) and _HASH.fullmatch(one) for one in hashes)
    ):
        raise ApiKeysError(f"{name}: sha256 must be a list of hashes of 64 hexadecimal digits")
    return hashes


def _count(name: str, table: dict[str, Any], quota: str) -> int | None:
    value = table.get(quota)
    if value is not None and (type(value) is not int or value < 1):
        raise ApiKeysError(f"{name}: {quota} must be a whole number of fits, at least 1")
    return value
