"""The composition root: the only place where adapters are made and connected."""

from service.bootstrap.application import application, drain, end_drain
from service.bootstrap.cluster import work

__all__ = ["application", "drain", "end_drain", "work"]
