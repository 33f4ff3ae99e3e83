"""Reverse proxies that remove a prefix from paths: one of Python's own, and nginx and Caddy where there are any."""

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import httpx

PREFIX = "/tools/ipfit"
HOP_BY_HOP = {"connection", "transfer-encoding", "keep-alive"}
NGINX = """
pid {folder}/nginx.pid; error_log {folder}/error.log; daemon off;
events {{ }}
http {{
  access_log off; client_max_body_size 100m;
  client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy; fastcgi_temp_path {folder}/f;
  uwsgi_temp_path {folder}/u; scgi_temp_path {folder}/s;
  server {{
    listen 127.0.0.1:{port};
    location {prefix}/ {{
      proxy_pass {url}/;
      proxy_set_header Host $host;
      proxy_set_header X-Forwarded-For $proxy_add_x_forwarded_for;
      proxy_set_header X-Forwarded-Proto $scheme;
    }}
  }}
}}
"""
CADDYFILE = """
{{
  admin off
}}
http://127.0.0.1:{port} {{
  handle_path {prefix}/* {{
    reverse_proxy {url}
  }}
}}
"""
PROGRAMS = {
    "nginx": (NGINX, ["-p", "{folder}", "-c", "{folder}/nginx.conf"]),
    "caddy": (CADDYFILE, ["run", "--adapter", "caddyfile", "--config", "{folder}/caddy.conf"]),
}


def program(name: str) -> str | None:
    """Return the path of a proxy, or None if it is not installed; Debian's nginx is where only root looks."""
    return shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin")


@contextmanager
def plain_proxy(url: str) -> Iterator[str]:
    """Yield the address of a proxy in this process, in front of the server at `url`."""

    class Forward(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def answer(self) -> None:
            body = self.rfile.read(int(self.headers.get("content-length", 0)))
            headers = {name: value for name, value in self.headers.items() if name.lower() not in HOP_BY_HOP}
            path = self.path.removeprefix(PREFIX)
            got = httpx.request(self.command, url + path, content=body, headers=headers, timeout=60.0)
            self.send_response(got.status_code)
            for name, value in got.headers.items():
                if name not in {*HOP_BY_HOP, "content-length", "content-encoding"}:
                    self.send_header(name, value)
            self.send_header("content-length", str(len(got.content)))
            self.end_headers()
            self.wfile.write(got.content)

        do_GET = do_POST = do_DELETE = answer  # noqa: N815 - named by http.server

        def log_message(self, *_: object) -> None:
            """Stay silent."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Forward) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}{PREFIX}"
        server.shutdown()


@contextmanager
def installed_proxy(name: str, url: str, folder: Path) -> Iterator[str]:
    """Yield the address of one of `PROGRAMS` in front of the server at `url`."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    configuration, arguments = PROGRAMS[name]
    text = configuration.format(folder=folder, port=port, prefix=PREFIX, url=url)
    (folder / f"{name}.conf").write_text(text, encoding="utf-8")
    command = [str(program(name)), *(argument.format(folder=folder) for argument in arguments)]
    with (folder / "log").open("wb") as log:
        own = {"HOME": str(folder), "XDG_DATA_HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
        process = subprocess.Popen(command, env=os.environ | own, stdout=log, stderr=log)  # noqa: S603 - Debian's own
    try:
        for _ in range(100):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.05)
        yield f"http://127.0.0.1:{port}{PREFIX}"
    finally:
        process.terminate()
        process.wait(10.0)
