"""Receivers of callbacks: real HTTP servers on 127.0.0.1 that answer as they are told, and remember what came."""

import base64
import hashlib
import hmac
import ssl
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Event, Thread
from typing import Any

import orjson

SECRET = "whsec_" + base64.b64encode(bytes(range(32))).decode()
OTHER_SECRET = "whsec_" + base64.b64encode(bytes(range(100, 140))).decode()
# The settings of a server that may send callbacks to these receivers.
ALLOWED = {"CALLBACK_SECRET": SECRET, "CALLBACK_ALLOW_HTTP": 1, "CALLBACK_ALLOW_PRIVATE": "127.0.0.0/8"}


@dataclass(frozen=True)
class Message:
    """A request that came."""

    path: str
    headers: dict[str, str]
    body: bytes

    @property
    def id(self) -> str:
        return self.headers["webhook-id"]

    @property
    def event(self) -> dict[str, Any]:
        event: dict[str, Any] = orjson.loads(self.body)
        return event

    def signed_with(self, secret: str) -> bool:
        """Return whether a signature is that of this secret: by the specification's sentences, and none of our code."""
        assert abs(time.time() - int(self.headers["webhook-timestamp"])) < 300
        content = b".".join([self.id.encode(), self.headers["webhook-timestamp"].encode(), self.body])
        mac = hmac.new(base64.b64decode(secret.partition("_")[2]), content, hashlib.sha256).digest()
        return f"v1,{base64.b64encode(mac).decode()}" in self.headers["webhook-signature"].split(" ")


@dataclass
class Receiver:
    """A receiver; each answer is a status, or the bytes of a whole response. The last one is given for ever."""

    answers: list[int | bytes]
    headers: dict[str, str] = field(default_factory=dict)
    scheme: str = "http"
    port: int = 0
    messages: list[Message] = field(default_factory=list)
    go_on: Event = field(default_factory=Event)  # no request is answered before

    @property
    def url(self) -> str:
        return f"{self.scheme}://127.0.0.1:{self.port}"

    def take(self, message: Message) -> int | bytes:
        self.messages.append(message)
        self.go_on.wait(60.0)
        return self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]


@contextmanager
def receiver(
    *answers: int | bytes, headers: dict[str, str] | None = None, tls: ssl.SSLContext | None = None, held: bool = False
) -> Iterator[Receiver]:
    """Yield a receiver that gives these answers; if `held`, not before it is told to go on."""
    made = Receiver(list(answers) or [204], headers or {}, "http" if tls is None else "https")
    if not held:
        made.go_on.set()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            answer = made.take(Message(self.path, {name.lower(): value for name, value in self.headers.items()}, body))
            if isinstance(answer, bytes):
                self.wfile.write(answer)
                return
            self.send_response(answer)
            for name, value in made.headers.items():
                self.send_header(name, value)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Stay silent."""

    class Server(ThreadingHTTPServer):
        daemon_threads = True

        def handle_error(self, *_: object) -> None:
            """Stay silent: senders that are killed, and clients that do not trust the certificate, cut connections."""

    with Server(("127.0.0.1", 0), Handler) as server:
        if tls is not None:
            server.socket = tls.wrap_socket(server.socket, server_side=True, do_handshake_on_connect=False)
        made.port = server.server_address[1]
        Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        yield made
        made.go_on.set()
        server.shutdown()
