"""The tables of fits and of their callbacks, the same on SQLite and on PostgreSQL."""

from datetime import UTC, datetime

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    DateTime,
    Dialect,
    Float,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    false,
)
from sqlalchemy.types import TypeDecorator

from service.jobs.fit import FitStatus
from service.store.migrations import MigrationStep


class Moment(TypeDecorator[datetime]):
    """A point in time with its zone; SQLite, which has no zones, stores it in UTC."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Return the value that the database stores."""
        if value is None or dialect.name != "sqlite":
            return value
        return value.astimezone(UTC).replace(tzinfo=None)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:  # noqa: ARG002 - the signature of SQLAlchemy
        """Return the value that the database gave, in UTC."""
        if value is None:
            return None
        return value.astimezone(UTC) if value.tzinfo else value.replace(tzinfo=UTC)


class Status(TypeDecorator[FitStatus]):
    """The status of a fit, stored as its word."""

    impl = String
    cache_ok = True

    def process_bind_param(self, value: FitStatus | None, dialect: Dialect) -> str | None:  # noqa: ARG002 - the signature of SQLAlchemy
        """Return the value that the database stores."""
        return None if value is None else value.value

    def process_result_value(self, value: str | None, dialect: Dialect) -> FitStatus | None:  # noqa: ARG002 - the signature of SQLAlchemy
        """Return the status that the database gave."""
        return None if value is None else FitStatus(value)


metadata = MetaData()
fits = Table(
    "fits",
    metadata,
    Column("id", String, primary_key=True),
    Column("status", Status, nullable=False, index=True),
    Column("input", String, nullable=False, index=True),
    Column("dimension", Integer, nullable=False),
    Column("points", Integer, nullable=False),
    Column("options", LargeBinary, nullable=False),
    Column("client", String, nullable=False),
    Column("owner", String, nullable=False, default="", server_default="", index=True),  # the name of its API key
    Column("cost", Float, nullable=False),
    Column("key", String, unique=True),  # NULL for fits without one
    Column("payload", String, nullable=False),
    Column("created", Moment, nullable=False, index=True),
    Column("started", Moment),
    Column("finished", Moment, index=True),
    Column("touched", Moment, nullable=False),  # when its status last changed
    Column("holder", String),
    Column("lease", Moment),  # when it runs out, unless the holder renews it
    Column("attempt", Integer, nullable=False, default=0),
    Column("crashes", Integer, nullable=False, default=0),
    Column("abandoned", Integer, nullable=False, default=0),
    Column("size", BigInteger, nullable=False),  # bytes of input and result
    Column("job", BigInteger, index=True),  # in the queue of the same database, if there is one
    Column("progress", LargeBinary),
    Column("result", LargeBinary),
    Column("failure", LargeBinary),
    # A part of a fit is a row like that of a fit, so that leases, crashes and everything else work for parts, too. Its
    # result is stored in the row and not as a blob: it has some hundreds of kilobytes, it is stored in the transaction
    # that ends the attempt, and it is removed in the one that ends the fit, so that it can never be left over.
    Column("parts", Integer, nullable=False, default=0),
    Column("unsummed", Integer, nullable=False, default=0),
    Column("whole", String, index=True),
    Column("slice", String),
    Column("summary", String),  # JSON of what was worked out when the input was checked
    # When it is taken from the queue of the same database, if there is one: `service.store.turns`.
    Column("turn", Float, nullable=False, default=0.0, server_default="0"),
    Column("place", Integer, nullable=False, default=0, server_default="0"),
    Column("short_lane", Boolean, nullable=False, default=False, server_default=false()),
)
# Apart from the fits: a callback that is still to be delivered outlives its fit when that is removed for its age.
callbacks = Table(
    "callbacks",
    metadata,
    Column("fit", String, primary_key=True),
    Column("url", String, nullable=False),
    Column("host", String, nullable=False),
    Column("client", String, nullable=False, server_default=""),  # of the fit: clients share the sending of callbacks
    Column("state", String, nullable=False),
    Column("tries", Integer, nullable=False),
    Column("due", Moment, index=True),  # NULL before the end of the fit, and when nothing is to be sent any more
    Column("status", Status),  # how and when the fit ended
    Column("ended", Moment),
    Column("last_error", String),
)
# Apart from the fits, too: a fit that was removed still counts for the quota of its owner.
acceptances = Table(
    "acceptances",
    metadata,
    Column("fit", String, primary_key=True),
    Column("owner", String, nullable=False),
    Column("accepted", Moment, nullable=False),
    Index("ix_acceptances_recent", "owner", "accepted"),
)
# The turn that the next fit of each client would have, where that is not now.
turns = Table(
    "turns",
    metadata,
    Column("client", String, primary_key=True),
    Column("until", Float, nullable=False),
)
# Whoever changes the tables above adds a migration here that changes older ones in the same way, named after the
# release. Each is one statement: SQLite takes no more at once.
FITS = MigrationStep(
    name="fits",
    table="fits",
    make=metadata.create_all,
    steps={
        "0.1.0": "",
        "0.2.0 parts": "ALTER TABLE fits ADD COLUMN parts INTEGER NOT NULL DEFAULT 0",
        "0.2.0 unsummed": "ALTER TABLE fits ADD COLUMN unsummed INTEGER NOT NULL DEFAULT 0",
        "0.2.0 whole": "ALTER TABLE fits ADD COLUMN whole VARCHAR",
        "0.2.0 whole, found": "CREATE INDEX ix_fits_whole ON fits (whole)",
        "0.2.0 slice": "ALTER TABLE fits ADD COLUMN slice VARCHAR",
        "0.2.0 summary": "ALTER TABLE fits ADD COLUMN summary VARCHAR",
        "0.2.0 owner": "ALTER TABLE fits ADD COLUMN owner VARCHAR NOT NULL DEFAULT ''",
        "0.2.0 owner, found": "CREATE INDEX ix_fits_owner ON fits (owner)",
        "0.2.0 callbacks": "CREATE TABLE callbacks (fit VARCHAR NOT NULL PRIMARY KEY, url VARCHAR NOT NULL,"
        " host VARCHAR NOT NULL, state VARCHAR NOT NULL, tries INTEGER NOT NULL, due TIMESTAMP WITH TIME ZONE,"
        " status VARCHAR, ended TIMESTAMP WITH TIME ZONE, last_error VARCHAR)",
        "0.2.0 callbacks, found": "CREATE INDEX ix_callbacks_due ON callbacks (due)",
        "0.2.0 callbacks, client": "ALTER TABLE callbacks ADD COLUMN client VARCHAR NOT NULL DEFAULT ''",
        "0.2.0 acceptances": "CREATE TABLE acceptances (fit VARCHAR NOT NULL PRIMARY KEY, owner VARCHAR NOT NULL,"
        " accepted TIMESTAMP WITH TIME ZONE NOT NULL)",
        "0.2.0 acceptances, found": "CREATE INDEX ix_acceptances_recent ON acceptances (owner, accepted)",
        "0.2.0 turn": "ALTER TABLE fits ADD COLUMN turn FLOAT NOT NULL DEFAULT 0",
        "0.2.0 place": "ALTER TABLE fits ADD COLUMN place INTEGER NOT NULL DEFAULT 0",
        "0.2.0 short lane": "ALTER TABLE fits ADD COLUMN short_lane BOOLEAN NOT NULL DEFAULT FALSE",
        "0.2.0 turns": "CREATE TABLE turns (client VARCHAR NOT NULL PRIMARY KEY, until FLOAT NOT NULL)",
    },
    columns=frozenset(fits.columns.keys()),
)
