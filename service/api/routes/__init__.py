"""The routes, a module for each resource, in the order in which the OpenAPI document lists them."""

from service.api.routes import fits, health, zero_sets

ROUTERS = (fits.router, zero_sets.router, health.router)
