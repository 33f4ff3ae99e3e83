"""The log as JSON: each line an object, with the request for which it was written."""

import json
import signal
from pathlib import Path

from tests.service.bodies import ellipse, npy
from tests.service.conftest import Start
from tests.service.running import Program, until


def test_each_line_is_an_object_that_names_its_request(start: Start) -> None:
    server = start(LOG_FORMAT="json", WORKERS=1)
    sent = {"Content-Type": "application/x-npy", "X-Request-Id": "mine-1"}
    answer = server.client.post("/v1/fits", content=npy(ellipse(50)), headers=sent)
    lines = [json.loads(line) for line in server.log.splitlines()]
    assert all({"time", "level", "logger", "message"} <= line.keys() for line in lines)
    (mine,) = [line for line in lines if line.get("request_id") == "mine-1" and line["logger"] == "uvicorn.access"]
    assert (mine["method"], mine["path"], mine["status"]) == ("POST", "/v1/fits", 200)
    assert mine["trace_id"] == answer.headers["traceparent"].split("-")[1]
    assert "there are no API keys" in next(line["message"] for line in lines if line["level"] == "WARNING")


def test_a_quiet_log_has_warnings_only(tmp_path: Path) -> None:
    server = Program("serve", tmp_path / "data", LOG_LEVEL="warning")
    until(lambda: "there are no API keys" in server.log)
    server.process.send_signal(signal.SIGTERM)
    assert server.process.wait(30.0) == 0
    assert " INFO " not in server.log
