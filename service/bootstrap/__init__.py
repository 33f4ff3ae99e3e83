"""The only place where parts are put together."""

from service.bootstrap.application import application, drain, hurry
from service.bootstrap.cluster import work

__all__ = ["application", "drain", "hurry", "work"]
