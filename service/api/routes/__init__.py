"""The routes, a module for each resource, in the order in which the OpenAPI document lists them."""

from service.api.routes import fits, health, lists, points, problem_types, zero_sets

ROUTERS = (
    fits.router,
    lists.router,
    zero_sets.router,
    points.router,
    problem_types.router,
    health.router,
)
