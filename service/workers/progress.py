"""Word from inside a worker: datagrams on a Unix socket.

Nothing is locked, so a worker that is killed in the middle cannot block the others.
"""

import os
import shutil
import socket
import tempfile
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

import orjson

_LARGEST = 65536
_STOP = b""
# Seconds that a report waits for room. The system keeps some ten of them, which the first degrees of a fit, a
# millisecond each, fill when the receiver is busy.
PATIENCE = 0.2


class _Sender:
    """Where this process's reports go; set when a worker starts and at each task."""

    channel: socket.socket | None = None
    folder: Path = Path()
    task: str = ""


def connect(address: str) -> None:
    """Send this process's reports to `address` from now on."""
    _Sender.folder = Path(address).parent
    _Sender.channel = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    _Sender.channel.settimeout(PATIENCE)
    _Sender.channel.connect(address)


def begin(task: str) -> None:
    """Mark the following reports as this task's, and leave word which process works on it."""
    _Sender.task = task
    (_Sender.folder / task).write_text(str(os.getpid()), encoding="ascii")


def report(payload: object) -> None:
    """Send a small JSON-able value to whoever started the task. Lost if nobody reads it."""
    if _Sender.channel is None:
        return
    try:
        _Sender.channel.send(orjson.dumps([_Sender.task, payload]))
    except OSError:
        return


class Inbox:
    """The receiving end: a thread that hands each report to its task's listener."""

    def __init__(self) -> None:
        """Open the socket and start listening."""
        self._folder = tempfile.mkdtemp(prefix="ipfit-")
        self.address = str(Path(self._folder) / "progress")
        self._listeners: dict[str, Callable[[Any], None]] = {}
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(self.address)
        os.chmod(self.address, 0o600)  # noqa: PTH101 - a socket, not a file of ours
        self._thread = Thread(target=self._listen, name="progress", daemon=True)
        self._thread.start()

    def listen(self, task: str, listener: Callable[[Any], None]) -> None:
        """Call `listener`, in the inbox's thread, with every report of this task."""
        self._listeners[task] = listener

    def worker(self, task: str) -> int | None:
        """Return the process that works on the task, or None if none has begun."""
        try:
            return int((Path(self._folder) / task).read_text(encoding="ascii"))
        except (FileNotFoundError, ValueError):  # a worker that is about to write the number has not begun either
            return None

    def forget(self, task: str) -> None:
        """Drop the task's listener, and the word about its process."""
        self._listeners.pop(task, None)
        (Path(self._folder) / task).unlink(missing_ok=True)

    def close(self) -> None:
        """Stop listening and remove the socket."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as me:
            me.sendto(_STOP, self.address)
        self._thread.join()
        self._socket.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _listen(self) -> None:
        while (message := self._socket.recv(_LARGEST)) != _STOP:
            task, payload = orjson.loads(message)
            listener = self._listeners.get(task)
            if listener is not None:
                listener(payload)
