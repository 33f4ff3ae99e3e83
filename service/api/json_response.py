"""Responses with JSON: with a strong entity tag, not sent to who has them, and compressed where that pays."""

from http import HTTPStatus

from fastapi import Request, Response

from service.api import negotiation, preconditions
from service.compression import compressed


def json_response(
    request: Request, body: bytes, headers: dict[str, str], status: HTTPStatus = HTTPStatus.OK
) -> Response:
    """Return a response with this JSON document; 304 to a GET whose sender has it already."""
    etag = preconditions.strong_etag(body)
    sent = {"ETag": etag, "Vary": "Accept-Encoding, Authorization", **headers}
    if request.method == "GET" and (known := preconditions.known(request, etag)) is not None:
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=sent | {"ETag": known})
    content, encoding = compressed(body, negotiation.content_encoding(request))
    if encoding is not None:
        sent |= {"ETag": preconditions.encoded_etag(etag, encoding), "Content-Encoding": encoding}
    return Response(content, status, sent, "application/json")
