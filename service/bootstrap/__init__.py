"""The composition root: the only place where adapters are made and connected."""

from service.bootstrap.application import application, drain, end_drain
from service.bootstrap.components import connection_limits

__all__ = ["application", "connection_limits", "drain", "end_drain"]
