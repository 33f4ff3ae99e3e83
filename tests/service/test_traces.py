"""Traces of requests, as OpenTelemetry's exporter sends them to a collector."""

from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest
from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest
from opentelemetry.proto.trace.v1.trace_pb2 import Span

from tests.service.bodies import ellipse, npy
from tests.service.running import Server, until

NPY = {"Content-Type": "application/x-npy"}


class Collector:
    """Takes what is exported by OTLP over HTTP."""

    def __init__(self) -> None:
        self.spans: list[Span] = []
        spans = self.spans

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                if self.path == "/v1/traces":
                    for resource in ExportTraceServiceRequest.FromString(body).resource_spans:
                        spans.extend(span for scope in resource.scope_spans for span in scope.spans)
                self.send_response(200)
                self.end_headers()

            def log_message(self, *_: object) -> None:
                """Say nothing."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        Thread(target=self._server.serve_forever, daemon=True).start()

    def named(self, name: str) -> list[Span]:
        """Return the spans of this name, as soon as there are any."""
        return until(lambda: [one for one in self.spans if one.name == name])

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


@pytest.fixture
def collector() -> Iterator[Collector]:
    made = Collector()
    yield made
    made.close()


@pytest.fixture
def traced(tmp_path: Path, collector: Collector, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", collector.url)
    monkeypatch.setenv("OTEL_BSP_SCHEDULE_DELAY", "100")
    server = Server(tmp_path / "data")
    yield server
    server.stop()


def test_a_request_is_a_trace_with_its_phases(traced: Server, collector: Collector) -> None:
    caller = f"00-{'a' * 32}-{'b' * 16}-01"
    answer = traced.client.post("/v1/fits", content=npy(ellipse()), headers=NPY | {"Traceparent": caller})
    (whole,) = collector.named("POST /v1/fits")
    assert (whole.trace_id.hex(), whole.parent_span_id.hex()) == ("a" * 32, "b" * 16)
    assert answer.headers["Traceparent"] == f"00-{'a' * 32}-{whole.span_id.hex()}-01"
    for name in ("read", "store", "wait"):
        (part,) = collector.named(name)
        assert part.trace_id == whole.trace_id
        assert whole.start_time_unix_nano <= part.start_time_unix_nano <= part.end_time_unix_nano
        assert part.end_time_unix_nano <= whole.end_time_unix_nano


def test_an_answer_names_the_trace_that_was_begun_for_it(traced: Server, collector: Collector) -> None:
    answer = traced.client.get("/v1/fits/0")
    (whole,) = collector.named("GET /v1/fits/{fit_id}")
    assert answer.headers["Traceparent"] == f"00-{whole.trace_id.hex()}-{whole.span_id.hex()}-01"
    assert traced.client.get("/livez").is_success
    assert traced.client.get("/v1/fits").is_success
    collector.named("GET /v1/fits")
    assert not [one for one in collector.spans if "/livez" in one.name]
