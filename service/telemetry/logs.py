"""The log: lines on standard error, each with the request for which it was written, as text or as JSON."""

import logging
from logging.config import dictConfig
from typing import Any

from service.request_ids import CURRENT

LINE = "%(asctime)s %(levelname)s %(name)s: %(message)s%(request)s"
# The members of a line of JSON, by the names that Python's logging has for them, and those of a line about an answer.
_MEMBERS = {"levelname": "level", "name": "logger", "message": "message", "exc_info": "exception"}
_ACCESS = ("client", "method", "path", "http_version", "status")


class RequestText(logging.Filter):
    """Adds the present request's ids to each record, as the attribute `request`, for a line of text."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Let every record pass."""
        ids = CURRENT.get()
        record.request = "" if ids is None else f" [request {ids.request_id}, trace {ids.trace_id}]"
        return True


class RequestMembers(logging.Filter):
    """Adds the present request's ids to each record as members of JSON, and what uvicorn tells of its answer."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Let every record pass."""
        ids = CURRENT.get()
        if ids is not None:
            record.request_id, record.trace_id, record.span_id = ids.request_id, ids.trace_id, ids.span_id
        if record.name == "uvicorn.access" and isinstance(record.args, tuple):
            for name, value in zip(_ACCESS, record.args, strict=False):
                setattr(record, name, value)
        return True


def log_config(form: str, level: str) -> dict[str, Any]:
    """Return the configuration of all loggers, as `logging.config` takes it; IPFIT_LOG_FORMAT and IPFIT_LOG_LEVEL."""
    members = {
        "()": "pythonjsonlogger.orjson.OrjsonFormatter",
        "fmt": list(_MEMBERS),
        "rename_fields": _MEMBERS,
        "timestamp": "time",
    }
    filters = {"text": RequestText, "json": RequestMembers}
    return {
        "version": 1,
        "disable_existing_loggers": False,
        "filters": {name: {"()": kind} for name, kind in filters.items()},
        "formatters": {"text": {"format": LINE}, "json": members} if form == "json" else {"text": {"format": LINE}},
        "handlers": {"stderr": {"class": "logging.StreamHandler", "formatter": form, "filters": [form]}},
        "root": {"handlers": ["stderr"], "level": "WARNING"},
        "loggers": {name: {"level": level.upper()} for name in ("service", "uvicorn")},
    }


def configure(form: str, level: str) -> None:
    """Write the log from now on."""
    dictConfig(log_config(form, level))
