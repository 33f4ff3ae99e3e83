"""The OpenAPI document, and its page: Swagger UI from files of an installed package, which needs no network."""

import base64
import hashlib
import re
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import orjson
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, RedirectResponse
from fastapi.staticfiles import StaticFiles

from service.api.json_response import json_response
from service.api.problems import root_path
from service.api.whole_document import servers

ASSETS = "/docs/assets"
# Of the page: what it loads comes from this server, and no script runs but its files and its own inline one.
_PAGE_RULES = (
    "default-src 'self'; script-src 'self' '{script}'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_INLINE_SCRIPT = re.compile(rb"<script>(.*?)</script>", re.DOTALL)

router = APIRouter(include_in_schema=False)


@router.get("/openapi.json")
async def openapi(request: Request) -> Response:
    """Return the OpenAPI document, in which the server is this one as the caller reaches it."""
    body = orjson.dumps(request.app.openapi() | {"servers": servers(root_path(request))})
    return json_response(request, body, {"Cache-Control": "no-cache"})


@router.get("/docs")
async def docs(request: Request) -> HTMLResponse:
    """Return Swagger UI for the OpenAPI document of this server."""
    return _page(root_path(request))


@router.get("/")
async def root(request: Request) -> RedirectResponse:
    """Redirect to the documentation."""
    return RedirectResponse(f"{root_path(request)}/docs")


@lru_cache(maxsize=1)
def _page(root: str) -> HTMLResponse:
    page = get_swagger_ui_html(
        openapi_url=f"{root}/openapi.json",
        title="ipfit",
        swagger_js_url=f"{root}{ASSETS}/swagger-ui-bundle.js",
        swagger_css_url=f"{root}{ASSETS}/swagger-ui.css",
        swagger_favicon_url=f"{root}{ASSETS}/favicon.png",
        swagger_ui_parameters={"validatorUrl": None},  # else Swagger UI loads a badge from the server of its authors
    )
    (script,) = _INLINE_SCRIPT.findall(bytes(page.body))
    digest = base64.b64encode(hashlib.sha256(script).digest()).decode()
    page.headers["Content-Security-Policy"] = _PAGE_RULES.format(script=f"sha256-{digest}")
    page.headers["Cache-Control"] = "no-cache"
    return page


def install(app: FastAPI) -> None:
    """Add the document, the page and its files to the application."""
    spec = find_spec("fastapi_offline")
    if spec is None or spec.origin is None:  # pragma: no cover - a declared dependency
        raise RuntimeError("fastapi-offline, which carries Swagger UI, is not installed")
    app.mount(ASSETS, StaticFiles(directory=Path(spec.origin).parent / "static"))
    app.include_router(router)
