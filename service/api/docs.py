"""The documentation page: Swagger UI from files of an installed package, so that it works without a network."""

from importlib.util import find_spec
from pathlib import Path

from fastapi import APIRouter, FastAPI, Request
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, RedirectResponse
from fastapi.staticfiles import StaticFiles

ASSETS = "/docs/assets"

router = APIRouter(include_in_schema=False)


@router.get("/docs")
async def docs(request: Request) -> HTMLResponse:
    """Return Swagger UI for the OpenAPI document of this server."""
    root: str = request.scope.get("root_path", "")
    return get_swagger_ui_html(
        openapi_url=f"{root}/openapi.json",
        title="ipfit",
        swagger_js_url=f"{root}{ASSETS}/swagger-ui-bundle.js",
        swagger_css_url=f"{root}{ASSETS}/swagger-ui.css",
        swagger_favicon_url=f"{root}{ASSETS}/favicon.png",
        swagger_ui_parameters={"validatorUrl": None},  # else Swagger UI loads a badge from the server of its authors
    )


@router.get("/")
async def root(request: Request) -> RedirectResponse:
    """Redirect to the documentation."""
    return RedirectResponse(f"{request.scope.get('root_path', '')}/docs")


def install(app: FastAPI) -> None:
    """Add the page and its files to the application."""
    spec = find_spec("fastapi_offline")
    if spec is None or spec.origin is None:  # pragma: no cover - a declared dependency
        raise RuntimeError("fastapi-offline, which carries Swagger UI, is not installed")
    app.mount(ASSETS, StaticFiles(directory=Path(spec.origin).parent / "static"))
    app.include_router(router)
