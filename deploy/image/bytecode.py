"""Import every module of the service, which must succeed, and store the bytecode of all that this loaded.

It goes where PYTHONPYCACHEPREFIX says: a server may not write, and would else compile a thousand modules at each start,
those of Python itself among them, because images of Python come without. What is never imported needs none.
"""

import pkgutil
import sys
from contextlib import redirect_stdout, suppress
from importlib import import_module
from io import BytesIO, TextIOWrapper
from py_compile import PycInvalidationMode, compile  # noqa: A004 - of a file, which is what is meant here

import ipcore
import service
from service.cli.app import app

# What is loaded only when a server starts, by its name; what is not installed is left out.
LATER = (
    "encodings.idna",
    "fsspec.implementations.local",
    "multiprocessing.popen_forkserver",
    "opentelemetry.exporter.otlp.proto.http.trace_exporter",
    "opentelemetry.sdk.trace.export",
    "s3fs",
    "sqlalchemy.dialects.postgresql.psycopg",
    "sqlalchemy.dialects.sqlite",
    "uvicorn.lifespan.on",
    "uvicorn.loops.uvloop",
)

# What needs an extra that the images come without; `ipfit verify` then says so.
WITHOUT = {"service.cli.verification"}

for package in (ipcore, service):
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not module.name.endswith(".__main__") and module.name not in WITHOUT:
            import_module(module.name)
for name in LATER:
    with suppress(ModuleNotFoundError):
        import_module(name)
with redirect_stdout(TextIOWrapper(BytesIO())):
    app(["openapi"], standalone_mode=False)  # makes the application, and with it what FastAPI loads only then

for name, loaded in list(sys.modules.items()):
    source = getattr(loaded, "__file__", None) or ""
    if source.endswith(".py") and name != "__main__":
        # Compared with the source by its content: times change when layers are packed, and whoever changes a file in an
        # image of his own shall get what he wrote.
        compile(source, doraise=True, invalidation_mode=PycInvalidationMode.CHECKED_HASH)
