"""Who may touch an input: those who add fits with it share it, and whoever removes it has it alone."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from sqlalchemy import Connection, Engine, text


class InputLocks:
    """The inputs of the fits in a database."""

    def __init__(self, engine: Engine) -> None:
        """Use this engine."""
        self._engine, self._alone = engine, Lock()

    @contextmanager
    def held(self, key: str, *, alone: bool = False) -> Iterator[Connection]:
        """Yield a transaction in which an input is not removed; or, `alone`, in which no fit with it is added."""
        if self._engine.dialect.name == "sqlite":  # a single process has it
            with self._alone, self._engine.begin() as connection:
                yield connection
            return
        lock = "pg_advisory_xact_lock" if alone else "pg_advisory_xact_lock_shared"
        with self._engine.begin() as connection:
            connection.execute(text(f"SELECT {lock}(:key)"), {"key": int(key[:15], 16)})
            yield connection
