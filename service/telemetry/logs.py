"""The log: lines on standard error, each with the request for which it was written."""

import logging
from logging.config import dictConfig
from typing import Any

from service.request_ids import CURRENT

LINE = "%(asctime)s %(levelname)s %(name)s: %(message)s%(request)s"


class RequestFilter(logging.Filter):
    """Adds the present request's ids to each record, as the attribute `request`."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Let every record pass."""
        ids = CURRENT.get()
        record.request = "" if ids is None else f" [request {ids.request_id}, trace {ids.trace_id}]"
        return True


def log_config() -> dict[str, Any]:
    """Return the configuration of all loggers, as `logging.config` takes it."""
    return {
        "version": 1,
        "disable_existing_loggers": False,
        "filters": {"request": {"()": RequestFilter}},
        "formatters": {"line": {"format": LINE}},
        "handlers": {"stderr": {"class": "logging.StreamHandler", "formatter": "line", "filters": ["request"]}},
        "root": {"handlers": ["stderr"], "level": "WARNING"},
        "loggers": {name: {"level": "INFO"} for name in ("service", "uvicorn")},
    }


def configure() -> None:
    """Write the log from now on."""
    dictConfig(log_config())
