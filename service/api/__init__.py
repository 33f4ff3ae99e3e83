"""The HTTP API: routes, parameters, representations, errors, and the OpenAPI document."""
