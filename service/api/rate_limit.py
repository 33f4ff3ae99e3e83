"""The fields RateLimit and RateLimit-Policy (IETF draft): what is left of a caller's quotas."""

from collections.abc import Iterable
from math import ceil

from service.jobs.admission import Allowance


def rate_limit_fields(allowances: Iterable[Allowance]) -> dict[str, str]:
    """Return the fields for what is left of each quota.

    >>> rate_limit_fields([Allowance("waiting", 500, 498, 1.2), Allowance("hourly", 9, 0, 60.0, 3600.0)])
    {'RateLimit-Policy': '"waiting";q=500, "hourly";q=9;w=3600', 'RateLimit': '"waiting";r=498;t=2, "hourly";r=0;t=60'}
    """
    told = list(allowances)
    policies = [f'"{one.name}";q={one.quota}' + (f";w={one.window:.0f}" if one.window else "") for one in told]
    left = [f'"{one.name}";r={one.remaining};t={ceil(one.reset)}' for one in told]
    return {"RateLimit-Policy": ", ".join(policies), "RateLimit": ", ".join(left)} if told else {}
