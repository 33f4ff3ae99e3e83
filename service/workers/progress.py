"""Reports from workers to the server: datagrams on a Unix socket.

No lock is held while one is sent, so a worker that is killed cannot block the others.
"""

import os
import socket
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

import orjson

from service.temporary_folders import TemporaryFolder

_LARGEST_REPORT = 65536  # bytes
_STOP = b""
# Seconds that a report waits for room in the socket's buffer. It holds some ten reports, and the first degrees of a fit
# take a millisecond each: they fill it when the receiver is busy.
SEND_TIMEOUT = 0.2


class _Sender:
    """The socket and the task of this process's reports; set when a worker starts and when a task begins."""

    channel: socket.socket | None = None
    folder: Path = Path()
    task: str = ""


def connect(address: str) -> None:
    """Send this process's reports to `address` from now on."""
    _Sender.folder = Path(address).parent
    _Sender.channel = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    _Sender.channel.settimeout(SEND_TIMEOUT)
    _Sender.channel.connect(address)


def begin(task: str) -> None:
    """Mark the following reports as those of this task, and write the number of this process to a file of its name."""
    _Sender.task = task
    (_Sender.folder / task).write_text(str(os.getpid()), encoding="ascii")


def report(payload: object) -> None:
    """Send a small value, as JSON, to the server. It is lost if nothing receives it."""
    if _Sender.channel is None:
        return
    try:
        _Sender.channel.send(orjson.dumps([_Sender.task, payload]))
    except OSError:
        return


class Inbox:
    """The receiver: a thread that calls the listener of a task with each of its reports."""

    def __init__(self) -> None:
        """Open the socket and start the thread."""
        self._folder = TemporaryFolder()
        self.address = str(self._folder.path / "progress")
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
        """Return the number of the process that works on a task, or None if none has begun."""
        try:
            return int((self._folder.path / task).read_text(encoding="ascii"))
        except (FileNotFoundError, ValueError):  # the file may still be empty
            return None

    def forget(self, task: str) -> None:
        """Forget the listener of a task, and the number of its process."""
        self._listeners.pop(task, None)
        (self._folder.path / task).unlink(missing_ok=True)

    def close(self) -> None:
        """End the thread and remove the socket."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as me:
            me.sendto(_STOP, self.address)
        self._thread.join()
        self._socket.close()
        self._folder.remove()

    def _listen(self) -> None:
        while (message := self._socket.recv(_LARGEST_REPORT)) != _STOP:
            task, payload = orjson.loads(message)
            listener = self._listeners.get(task)
            if listener is not None:
                listener(payload)
