"""Settings, from IPFIT_* environment variables."""

import os
from base64 import b64decode
from importlib.util import find_spec
from ipaddress import ip_network
from pathlib import Path
from typing import Literal

from fsspec.registry import known_implementations
from pydantic import Field, SecretStr, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.jobs.bounds import LARGEST_POINT_SET, LONGEST_ROOT_PATH, MOST_BODY_BYTES, MOST_RESOLUTION


class Settings(BaseSettings):
    """The settings of a server. The table in docs/settings.md is made from these fields."""

    model_config = SettingsConfigDict(env_prefix="IPFIT_", frozen=True)

    host: str = Field("127.0.0.1", description="Address to listen on.")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on; 0 takes a free one.")
    log_format: Literal["text", "json"] = Field("text", description="How lines of the log are written: `text`, `json`.")
    log_level: Literal["debug", "info", "warning", "error"] = Field(
        "info", description="What is written to the log: `debug`, `info`, `warning` or `error`, and what is graver."
    )
    probe_port: int | None = Field(
        None,
        ge=0,
        le=65535,
        description="Port at which `ipfit worker` answers `/livez`, `/readyz` and `/metrics`; by default it does not.",
    )
    forwarded_allow_ips: str = Field(
        "127.0.0.1",
        description="Addresses of reverse proxies whose `X-Forwarded-For` and `X-Forwarded-Proto` are believed, with "
        "commas between; `*` believes everybody.",
    )
    root_path: str = Field(
        "",
        pattern=r"^(/[A-Za-z0-9._~-]+)*$",
        max_length=LONGEST_ROOT_PATH,
        description="The prefix, such as `/ipfit`, that a reverse proxy removes from paths; links then begin with it.",
    )
    cors_origins: str = Field(
        "",
        pattern=r"^(\*|https?://[^\s,/]+(\s*,\s*https?://[^\s,/]+)*)?$",
        description="Origins, such as `https://app.example`, whose pages may call this server in a browser, with "
        "commas between; `*` means all; empty means none.",
    )
    max_connections: int | None = Field(
        None, ge=16, description="Connections that may be open at once; by default as many as files may be."
    )
    head_timeout: float = Field(10.0, gt=0, description="Seconds in which the head of a request has to arrive.")
    stall_timeout: float = Field(
        30.0,
        gt=0,
        description="Seconds after which a connection is closed whose body arrives, or whose response is taken, at "
        "less than 1 kB/s.",
    )
    database_url: str | None = Field(
        None,
        pattern="^postgres(ql)?://",
        description="A PostgreSQL (`postgresql://…`) that many servers and workers share; else SQLite in the folder.",
    )
    blobs_url: str | None = Field(
        None, description="Where point sets are stored: any fsspec URL that all machines share; else in the folder."
    )
    data_dir: Path = Field(
        Path("ipfit-data"), description="Folder of what one server keeps: its database, its point sets."
    )
    workers: int = Field(
        default_factory=lambda: os.cpu_count() or 1, ge=1, description="Fits that run at once, a process each."
    )
    short_workers: int = Field(
        1, ge=0, description="More workers, which run short fits only, so that these do not wait for long ones."
    )
    mesh_workers: int = Field(1, ge=1, description="Meshes and other files that are made at once, a process each.")
    worker_memory: int | None = Field(
        None,
        ge=2**29,
        description="Memory that a worker may take, in bytes; a fit that needs more fails. By default an equal share, "
        "0.5 to 8 GiB, of what the machine or the container has.",
    )
    server_memory: int = Field(
        2 * 2**30,
        ge=2**29,
        description="Memory that the server process itself may take, in bytes; a request that would need more is "
        "answered with 503.",
    )
    tasks_per_worker: int = Field(100, ge=1, description="Tasks after which a worker process is replaced.")
    fit_deadline: float = Field(
        600.0, gt=0, description="Seconds that a fit, or a part of one, may run before it is killed."
    )
    # In 3D a core sums the moments of so many points in two seconds or three; a job of its own costs some hundredths.
    split_points: int = Field(
        250_000,
        ge=1000,
        description="Points above which a linear fit with normals is split: workers sum parts of at most so many at "
        "once. As many as IPFIT_MAX_POINTS keep every fit in one piece.",
    )
    lease: float = Field(
        30.0, ge=1.0, description="Seconds after which a fit is taken from a supervisor that is not heard of any more."
    )
    queue_limit: int = Field(1000, ge=1, description="Fits that may wait; more are answered with 503.")
    queue_bytes: int = Field(
        8 * 2**30, ge=2**20, description="Bytes that the points of waiting fits may take; beyond, 503 is the answer."
    )
    client_share: float = Field(
        0.5,
        gt=0,
        le=1,
        description="The share of the waiting fits that may be of one client: an API key, or an address if there are "
        "no keys; more are answered with 429.",
    )
    waiting_requests: int = Field(
        16, ge=1, description="Uploads, and meshes, that may wait for their worker; more are answered with 503."
    )
    transit_bytes: int = Field(
        2**30,
        ge=2**20,
        description="Bytes of bodies that may be on their way in at once, half of them of one client; more are "
        "answered with 503.",
    )
    api_keys: Path | None = Field(
        None, description="A file with the API keys that may call this server; without it everybody may."
    )
    keep_seconds: float = Field(7 * 86400.0, gt=0, description="Seconds that a fit is kept after its end.")
    keep_bytes: int = Field(
        10 * 2**30, ge=0, description="Bytes that ended fits may take; beyond, the oldest are removed."
    )
    shutdown_grace: float = Field(
        8.0, ge=0, description="Seconds that running fits get to end after SIGTERM; the others run again later."
    )
    mesh_deadline: float = Field(60.0, gt=0, description="Seconds that reading an input or making a mesh may take.")
    max_mesh_bytes: int = Field(
        256 * 2**20, ge=2**20, le=MOST_BODY_BYTES, description="Largest file of a zero set, in bytes."
    )
    mesh_cache_bytes: int = Field(
        2**30, ge=2**20, description="Bytes on disk that meshes and other files may take, to be sent again."
    )
    max_body_bytes: int = Field(64 * 2**20, ge=1024, le=MOST_BODY_BYTES, description="Largest request body, in bytes.")
    max_points: int = Field(1_000_000, ge=4, le=LARGEST_POINT_SET, description="Most points in a point set.")
    max_degree_2d: int = Field(40, ge=1, le=40, description="Highest `max_degree` that a 2D fit may ask for.")
    max_degree_3d: int = Field(20, ge=1, le=20, description="Highest `max_degree` that a 3D fit may ask for.")
    max_system_bytes: int = Field(
        4 * 2**30,
        ge=2**20,
        description="Largest linear system that a fit may hold as a whole, in bytes: 8 · points · equations each · "
        "coefficients. Only other factors than moments and tsqr do.",
    )
    max_resolution_2d: int = Field(
        2048, ge=16, le=MOST_RESOLUTION, description="Most grid points along an axis to be asked for in 2D."
    )
    max_resolution_3d: int = Field(
        256, ge=16, le=MOST_RESOLUTION, description="Most grid points along an axis to be asked for in 3D."
    )
    max_wait: float = Field(300.0, ge=0, description="Longest that a request may wait for a fit, in seconds.")
    callback_secret: SecretStr | None = Field(
        None,
        description="What callbacks are signed with: `whsec_` and the base64 of 24 to 64 random bytes; or several of "
        "these with spaces between. Without one, callbacks are refused.",
    )
    callback_allow_http: bool = Field(
        False,  # noqa: FBT003 - pydantic's signature
        description="Whether callbacks may have http URLs, too; the messages are signed, but not encrypted then.",
    )
    callback_allow_private: str = Field(
        "",
        description="Networks that callbacks may be sent to though they are not public, with commas between, such as "
        "`10.0.0.0/8,fd00::/8`.",
    )

    @field_validator("blobs_url")
    @classmethod
    def _check_storage(cls, value: str | None) -> str | None:
        """Refuse storage whose package is missing: the server would start, and fail at every fit."""
        kind = (value or "").partition("://")[0]
        known = known_implementations.get(kind, {"class": __name__})
        if find_spec(known["class"].partition(".")[0]) is None:
            hint = 'pip install "ipfit[s3]", or the container image for S3' if kind == "s3" else known.get("err", "")
            raise ValueError(f"the package for {kind}:// is not installed: {hint}")
        return value

    @field_validator("callback_secret")
    @classmethod
    def _check_secret(cls, value: SecretStr | None) -> SecretStr | None:
        """Refuse what is no secret of the Standard Webhooks specification; the message must not repeat it."""
        words = [] if value is None else value.get_secret_value().split()
        if not all(map(_is_secret, words)):
            raise ValueError("each secret must be whsec_ and the base64 of 24 to 64 bytes")
        return value if words else None

    @field_validator("callback_allow_private")
    @classmethod
    def _check_networks(cls, value: str) -> str:
        """Refuse what is no list of networks."""
        for part in filter(None, map(str.strip, value.split(","))):
            ip_network(part)
        return value


def _is_secret(word: str) -> bool:
    kind, _, encoded = word.partition("_")
    try:
        return kind == "whsec" and 24 <= len(b64decode(encoded, validate=True)) <= 64
    except ValueError:
        return False


def table() -> str:
    """Return the settings as a Markdown table: variable, default, meaning."""
    rows = ["| variable | default | meaning |", "| --- | --- | --- |"]
    for name, field in Settings.model_fields.items():
        default = "the number of cores" if field.default_factory else f"`{field.default}`".replace("`None`", "")
        rows.append(f"| `IPFIT_{name.upper()}` | {default} | {field.description} |")
    return "\n".join(rows)
