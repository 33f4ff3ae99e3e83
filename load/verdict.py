"""Checks of every promise against the store's record of transitions and against the servers' answers at the end."""

import hashlib
import sqlite3
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from typing import Any

import httpx
import psycopg

from load.clients import FINAL, Caller, Log, Promise
from load.fleet import Fleet
from service.jobs.fit import MAX_ABANDONED, MAX_CRASHES, TRANSITIONS, FitStatus

# A trigger of the store records every transition in the transaction that makes it, also from a final status to itself.
IS_TRANSITION = "OLD.status <> NEW.status OR OLD.status IN ('successful', 'failed', 'dismissed')"
SQLITE = f"""
CREATE TABLE audit (fit TEXT, old TEXT, new TEXT);
CREATE TRIGGER audit AFTER UPDATE OF status ON fits WHEN {IS_TRANSITION}
BEGIN INSERT INTO audit VALUES (OLD.id, OLD.status, NEW.status); END;
"""  # noqa: S608 - our own words
POSTGRESQL = f"""
CREATE TABLE audit (fit TEXT, old TEXT, new TEXT);
CREATE FUNCTION audit() RETURNS trigger LANGUAGE plpgsql AS
'BEGIN INSERT INTO audit VALUES (OLD.id, OLD.status, NEW.status); RETURN NEW; END';
CREATE TRIGGER audit AFTER UPDATE OF status ON fits FOR EACH ROW WHEN ({IS_TRANSITION})
EXECUTE FUNCTION audit();
"""  # noqa: S608 - as above
# The messages with which a fit may fail here.
CRASHED = f"The worker process died {MAX_CRASHES} times."
LEFT = f"The process that supervised the fit died {MAX_ABANDONED} times."
# Seconds after the last fault within which every fit must have ended.
END_WITHIN = 240.0


def install_audit(fleet: Fleet) -> None:
    """Install the trigger that records transitions."""
    if fleet.database is not None:
        with psycopg.connect(fleet.database, autocommit=True) as connection:
            connection.execute(POSTGRESQL)
        return
    with closing(sqlite3.connect(fleet.folder / "data" / "fits.sqlite")) as connection:
        connection.executescript(SQLITE)


def rows(fleet: Fleet, query: str) -> list[tuple[Any, ...]]:
    """Return the rows of a query to the store."""
    if fleet.database is not None:
        with psycopg.connect(fleet.database) as connection:
            return connection.execute(query.encode()).fetchall()
    with closing(sqlite3.connect(fleet.folder / "data" / "fits.sqlite")) as connection:
        return connection.execute(query).fetchall()


class Verdict:
    """The end of every accepted fit, and the broken promises by kind."""

    def __init__(self, fleet: Fleet, log: Log, reference: list[dict[str, Any]]) -> None:
        self._fleet, self._log, self._reference = fleet, log, reference
        self._asker = Caller(0, fleet.ports, log, 0)
        self._transitions: list[tuple[Any, ...]] = []
        self.ends: Counter[str] = Counter()
        self.parts: Counter[str] = Counter()
        self.lost: list[str] = []
        self.twice: list[str] = []
        self.stuck: list[str] = []
        self.wrong: list[str] = []

    def reach(self) -> None:
        """Wait until all fits have ended, then check every one."""
        end = time.monotonic() + END_WITHIN
        finals = [(promise, self._final(promise, end)) for promise in self._log.promises]
        self._transitions = rows(self._fleet, "SELECT fit, old, new FROM audit")
        for promise, fit in finals:
            self._check(promise, fit)
        self._check_moves()
        self._check_parts()
        self._check_keys()
        self._check_points()

    def _check(self, promise: Promise, fit: dict[str, Any] | None) -> None:
        if fit is None:
            if promise.deleted:
                self.ends["removed"] += 1
            else:
                self.lost.append(promise.fit)
            return
        if fit["status"] not in FINAL:
            self.stuck.append(f"{promise.fit} is {fit['status']}")
            return
        failed = fit["status"] == "failed"
        self.ends[f"failed ({fit['problem']['detail']})" if failed else fit["status"]] += 1
        if failed:
            self._explain(promise, fit["problem"])
        if promise.seen is not None and promise.seen != fit:
            self.twice.append(f"{promise.fit} was {promise.seen['status']}, {promise.seen['finished']}, then another")
        if fit["status"] == "successful" and fit["polynomial"] != self._reference[promise.kind]["polynomial"]:
            self.wrong.append(f"{promise.fit}: another polynomial than from the same points in peace")
        if fit["status"] == "dismissed" and not promise.deleted:
            self.wrong.append(f"{promise.fit}: dismissed, and nobody asked for it")

    def _explain(self, promise: Promise, problem: dict[str, Any]) -> None:
        """Record a failed fit as unexplained, unless its processes were killed as often as the contract allows."""
        each = Counter(fit for fit, _, new in self._transitions if new == "running" and fit.startswith(promise.fit))
        starts = max(each.values(), default=0)  # of the fit, or of the part that was started most often
        enough = MAX_CRASHES if problem["detail"] == CRASHED else MAX_ABANDONED if problem["detail"] == LEFT else None
        if enough is None or starts < enough:
            self._log.unexplained.append(f"{promise.fit} failed after {starts} starts: {problem}")

    def _final(self, promise: Promise, end: float) -> dict[str, Any] | None:
        """Return the fit when it has ended or the time is up; None if it does not exist."""
        while True:
            patience = max(0, min(10, int(end - time.monotonic())))  # no wait when the time is up
            answer = self._asker.ask("GET", f"/v1/fits/{promise.fit}", headers={"Prefer": f"wait={patience}"})
            if answer is not None and answer.status_code == httpx.codes.NOT_FOUND:
                return None
            fit: dict[str, Any] = answer.json() if answer is not None and answer.is_success else {"status": "unknown"}
            if fit["status"] in FINAL or time.monotonic() > end:
                return fit
            time.sleep(0.2)

    def _check_moves(self) -> None:
        """Check that every transition is legal, and that no fit ended twice."""
        final: Counter[str] = Counter()
        for fit, old, new in self._transitions:
            if FitStatus(new) not in TRANSITIONS[FitStatus(old)]:
                self.wrong.append(f"{fit} went from {old} to {new}")
            final[fit] += new in FINAL
        self.twice += [f"{fit} ended {count} times" for fit, count in final.items() if count > 1]

    def _check_parts(self) -> None:
        """Check that every part of a successful fit ended once, and that no part is left."""
        started = Counter(fit for fit, _, new in self._transitions if new == "running" and "-" in fit)
        summed = Counter(fit for fit, _, new in self._transitions if new == "successful" and "-" in fit)
        self.parts.update({"summed": summed.total(), "started": started.total()})
        for fit, parts in rows(self._fleet, "SELECT id, parts FROM fits WHERE parts > 0 AND status = 'successful'"):
            counts = [count for part, count in summed.items() if part.startswith(fit)]
            self.parts["of successful fits"] += len(counts)
            if counts != [1] * parts and fit not in {one["id"] for one in self._reference}:
                self.wrong.append(f"{fit} has {parts} parts, which ended {counts} times")
        left = rows(self._fleet, "SELECT id FROM fits WHERE whole IS NOT NULL")
        self.wrong += [f"the part {part} is left" for (part,) in left]

    def _check_keys(self) -> None:
        """Check that there is one fit for each key, and none that no client was told of."""
        told = {promise.key: promise.fit for promise in self._log.promises}
        undisturbed = {fit["id"] for fit in self._reference}
        kept = [
            (key, fit)
            for key, fit in rows(self._fleet, "SELECT key, id FROM fits WHERE whole IS NULL")
            if fit not in undisturbed
        ]
        self.wrong += [f"{fit} is stored, and nobody was told" for key, fit in kept if told.get(key) != fit]
        if len(told) != len(self._log.promises) or len(set(told.values())) != len(told):
            self.wrong.append("two promises have one key or one fit")

    def _check_points(self) -> None:
        """Check that the points of every fit are there, and have the SHA-256 that is their name."""
        kept = {path.name: path for path in (self._fleet.blobs).rglob("*") if path.is_file()}
        for (key,) in rows(self._fleet, "SELECT DISTINCT input FROM fits"):
            if key not in kept or hashlib.sha256(kept[key].read_bytes()).hexdigest() != key:
                self.wrong.append(f"the points {key} are lost")


def undisturbed(ask: Callable[..., httpx.Response | None], kinds: list[tuple[bytes, str]]) -> list[dict[str, Any]]:
    """Return the answer for each kind of fit while nothing is killed."""
    found = []
    for content, query in kinds:
        headers = {"Content-Type": "application/x-npy", "Prefer": "wait=30"}
        answer = ask("POST", f"/v1/fits?{query}", content=content, headers=headers)
        if answer is None or answer.json().get("status") != "successful":
            raise RuntimeError(f"a fit does not succeed in peace: {answer and answer.text[:500]}")
        found.append(answer.json())
    return found
