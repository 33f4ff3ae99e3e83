"""The request of a callback, as an operation of the OpenAPI document: it is the caller who answers it."""

from typing import Any

from service.api.descriptions import reference


def _header(name: str, description: str, example: str) -> dict[str, Any]:
    schema = {"type": "string", "maxLength": 4096, "pattern": r"^[\x21-\x7e]+( [\x21-\x7e]+)*$"}
    return {
        "name": name,
        "in": "header",
        "required": True,
        "description": description,
        "schema": schema,
        "example": example,
    }


FIT_ENDED: dict[str, Any] = {
    "summary": "A fit has ended",
    "security": [],  # the signature of the message is what its receiver checks
    "description": "Sent until it is answered with a status from 200 to 299, at most 10 times in 22 hours; 410 ends "
    "it at once. It may come more than once: drop a `webhook-id` that came before. Check the signature, as the "
    "[Standard Webhooks](https://www.standardwebhooks.com) specification says.",
    "parameters": [
        _header("webhook-id", "Names the message, in every try.", "ended-0f8c6d2e5b7a4d1c9e3f6a8b0c2d4e5f"),
        _header("webhook-timestamp", "When this try was made, in seconds since 1970.", "1767225600"),
        _header(
            "webhook-signature",
            "`v1,` and the base64 of the HMAC-SHA256 of id, timestamp and body with dots between; if the server has "
            "several secrets, as many signatures with spaces between.",
            "v1,K5oZfzN95Z9UVu1EsfQmfVNQhnkZ2pj9o9NDN/H/pI4=",
        ),
    ],
    "requestBody": {"required": True, "content": {"application/json": {"schema": reference("FitEnded")}}},
    "responses": {
        "2XX": {"description": "Received. The body of the answer is not used."},
        "410": {"description": "Not wanted any more: it is not sent again."},
        "429": {"description": "Try again later; `Retry-After` counts, up to an hour. So it does with 503."},
    },
}
