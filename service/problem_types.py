"""The catalogue of problem types: every kind of error that an answer or a failed fit can name, and what helps.

This is the one list: the answers, the pages at /problems/…, the OpenAPI document and docs/problems.md come from it.
"""

from dataclasses import dataclass
from http import HTTPStatus


@dataclass(frozen=True)
class ProblemType:
    """A kind of problem (RFC 9457).

    Attributes
    ----------
    code
        Its stable name.
    status
        The HTTP status with which it is answered; None if it stands in a failed fit only.
    title
        The kind in words.
    remedy
        When it occurs, and what the caller can do.
    retry_after
        Seconds after which the same request may succeed; None if it will not, or if the server works them out.

    """

    code: str
    status: HTTPStatus | None
    title: str
    remedy: str
    retry_after: int | None = None

    def path(self, root: str = "") -> str:
        """Return the path of the page about it, which is its `type` in problem details.

        >>> PROBLEM_TYPES["queue-full"].path("/ipfit")
        '/ipfit/problems/queue-full'
        """
        return f"{root}/problems/{self.code}"


_S = HTTPStatus
_ALL = (
    ProblemType(
        "bad-request", _S.BAD_REQUEST, "The request cannot be understood", "It is not HTTP as RFC 9110 and 9112 say."
    ),
    ProblemType(
        "malformed-input",
        _S.BAD_REQUEST,
        "The body cannot be read",
        "It is not what its media type says: look at Content-Type or `format`, and whether the file is complete.",
    ),
    ProblemType(
        "malformed-header",
        _S.BAD_REQUEST,
        "A header cannot be read",
        'The detail names the header and shows a right one, such as `Idempotency-Key: "torus-1"` with its quotes.',
    ),
    ProblemType(
        "incomplete-request", _S.BAD_REQUEST, "The body ended early", "The caller closed the connection: send it again."
    ),
    ProblemType(
        "not-found", _S.NOT_FOUND, "There is nothing at this address", "`/docs` and `/openapi.json` list the addresses."
    ),
    ProblemType(
        "fit-not-found",
        _S.NOT_FOUND,
        "No such fit",
        "It never existed, was removed, or belongs to another API key. Ended fits are kept for IPFIT_KEEP_SECONDS.",
    ),
    ProblemType(
        "method-not-allowed",
        _S.METHOD_NOT_ALLOWED,
        "The method is not for this address",
        "`Allow` lists those that are.",
    ),
    ProblemType(
        "not-acceptable",
        _S.NOT_ACCEPTABLE,
        "No such format",
        "The answer cannot be had in the format that Accept or `format` asks for; the detail lists those that can.",
    ),
    ProblemType(
        "request-timeout", _S.REQUEST_TIMEOUT, "The request arrived too slowly", "Send it at more than 1 kB/s."
    ),
    ProblemType(
        "fit-not-finished",
        _S.CONFLICT,
        "The fit has not ended yet",
        "Wait: `GET` with `Prefer: wait=30`.",
        retry_after=1,
    ),
    ProblemType(
        "fit-without-result",
        _S.CONFLICT,
        "The fit ended without a result",
        "It failed or was dismissed; `problem` of a failed fit says why.",
    ),
    ProblemType(
        "precondition-failed",
        _S.PRECONDITION_FAILED,
        "The fit has changed",
        "If-Match names another state than the present one: read the fit again.",
    ),
    ProblemType(
        "too-large",
        _S.REQUEST_ENTITY_TOO_LARGE,
        "Over a limit of this server",
        "The body, the points, the linear system or the file asked for are too large; the detail names the limit.",
    ),
    ProblemType(
        "unsupported-media-type",
        _S.UNSUPPORTED_MEDIA_TYPE,
        "The media type is not read here",
        "The detail lists the media types that are.",
    ),
    ProblemType(
        "invalid-input",
        _S.UNPROCESSABLE_ENTITY,
        "The request cannot be carried out",
        "The points cannot be fitted, or an option has a value that is not allowed; `errors` say what and where.",
    ),
    ProblemType(
        "invalid-parameter",
        _S.UNPROCESSABLE_ENTITY,
        "A parameter is not allowed",
        "A query parameter is unknown, is given twice, or has a value that is not allowed; `errors` name it.",
    ),
    ProblemType(
        "key-reused",
        _S.UNPROCESSABLE_ENTITY,
        "The key came with another payload",
        "An Idempotency-Key names one request: take a new key for other points or other options.",
    ),
    ProblemType(
        "unauthorized",
        _S.UNAUTHORIZED,
        "No valid API key",
        "Send `Authorization: Bearer KEY` with a key that the operator of this server gave you.",
    ),
    ProblemType(
        "range-not-satisfiable",
        _S.REQUESTED_RANGE_NOT_SATISFIABLE,
        "The range lies outside of the file",
        "`Content-Range` has the length of the file.",
    ),
    ProblemType(
        "quota-exceeded",
        _S.TOO_MANY_REQUESTS,
        "Your quota is used up",
        "Nothing was accepted: wait as long as `Retry-After` says. `RateLimit` has what is left of each quota.",
    ),
    ProblemType(
        "head-too-large",
        _S.REQUEST_HEADER_FIELDS_TOO_LARGE,
        "The request's head is too large",
        "The request line and the headers together may have 64 kB and 256 fields.",
    ),
    ProblemType(
        "internal",
        _S.INTERNAL_SERVER_ERROR,
        "The server failed",
        "An error of the server's own; its log says more under the request's id. Please report it.",
    ),
    ProblemType(
        "not-implemented",
        _S.NOT_IMPLEMENTED,
        "The method is not known here",
        "Send one of those that /openapi.json lists.",
    ),
    ProblemType(
        "deadline-exceeded",
        _S.SERVICE_UNAVAILABLE,
        "The work took too long",
        "Reading a body, making a mesh or a fit took longer than this server allows: send fewer points, ask for a "
        "lower resolution or a lower max_degree.",
        retry_after=10,
    ),
    ProblemType(
        "out-of-memory",
        _S.SERVICE_UNAVAILABLE,
        "The work needs too much memory",
        "More than IPFIT_WORKER_MEMORY: send fewer points, ask for a lower resolution, or take another `factor`.",
        retry_after=10,
    ),
    ProblemType("worker-crashed", _S.SERVICE_UNAVAILABLE, "A worker died doing the work", "Try again.", retry_after=1),
    ProblemType(
        "queue-full", _S.SERVICE_UNAVAILABLE, "Too many requests wait", "Nothing was accepted: try again later."
    ),
    ProblemType(
        "shutting-down",
        _S.SERVICE_UNAVAILABLE,
        "The server is stopping",
        "Nothing was accepted, unless the server stopped in the moment of it: with the same Idempotency-Key, the "
        "request can be sent again in any case.",
        retry_after=10,
    ),
    ProblemType(
        "not-ready",
        _S.SERVICE_UNAVAILABLE,
        "The server is not ready",
        "Its disk is full, or its database or its storage of point sets is away. Nothing was accepted.",
        retry_after=10,
    ),
    ProblemType(
        "too-many-connections",
        _S.SERVICE_UNAVAILABLE,
        "Too many connections are open",
        "Close those that are not needed, or use one for many requests.",
        retry_after=10,
    ),
    ProblemType(
        "fit-error", None, "The fit failed", "The points cannot be fitted with these options; the detail says why."
    ),
)
PROBLEM_TYPES = {one.code: one for one in _ALL}


def table() -> str:
    """Return the problem types as a Markdown table: code, status, meaning and what helps."""
    rows = ["| `code` | status | what it is | when, and what helps |", "| --- | --- | --- | --- |"]
    for one in _ALL:
        status = "in a failed fit" if one.status is None else str(int(one.status))
        rows.append(f"| `{one.code}` | {status} | {one.title} | {one.remedy} |")
    return "\n".join(rows)
