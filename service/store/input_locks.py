"""Locks on the inputs of fits: shared while a fit with the input is added, exclusive while the input is removed."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from sqlalchemy import Connection, Engine, text


class InputLocks:
    """The locks on the inputs of the fits in a database."""

    def __init__(self, engine: Engine) -> None:
        """Use this engine."""
        self._engine, self._lock = engine, Lock()

    @contextmanager
    def locked(self, key: str, *, exclusive: bool = False) -> Iterator[Connection]:
        """Yield a transaction in which an input is not removed; with `exclusive`, no fit with it is added either."""
        if self._engine.dialect.name == "sqlite":  # used by a single process
            with self._lock, self._engine.begin() as connection:
                yield connection
            return
        function = "pg_advisory_xact_lock" if exclusive else "pg_advisory_xact_lock_shared"
        with self._engine.begin() as connection:
            connection.execute(text(f"SELECT {function}(:key)"), {"key": int(key[:15], 16)})
            yield connection
