"""The process that serves the page of a run, as the run sees it: told what there is to show, and never waited for."""

from contextlib import AbstractContextManager
from dataclasses import replace
from multiprocessing import Pipe
from threading import Condition, Thread
from typing import Any

from layflat.errors import InputError, LayflatError
from layflat.pages.cell.serving import serve_run
from layflat.pages.cell.snapshot import About, Requests, Snapshot
from layflat.pages.server.place import Place
from layflat.parallel import start_process

ENDS = 5.0  # in which it ends once it is told to, s


class PageLink(AbstractContextManager["PageLink"]):
    """Begins the process, and ends it at the end of a `with` block.

    Raises InputError where the place can't be had.

    Attributes:
        link: the start link of the page.
        asked: what people ask of the run there.
        snapshot: that was shown last.
    """

    def __init__(self, about: About, place: Place) -> None:
        self.asked, self.snapshot = Requests(), Snapshot()
        self._pipe, its = Pipe()
        self._newest: dict[str, object] = {}
        self._changed, self._closed = Condition(), False
        self._process = start_process(serve_run, (about, place, its, self.asked), "layflat-page", daemon=True)
        its.close()
        self._sender = Thread(target=self._send, name="layflat-page", daemon=True)
        try:
            self.link = self._opened()
            self._sender.start()
        except BaseException:
            self.close()
            raise

    def show(self, **changes: Any) -> None:
        """Change fields of the snapshot."""
        self.snapshot = replace(self.snapshot, **changes)
        self._put("snapshot", self.snapshot)

    def image(self, name: str, jpeg: bytes) -> None:
        """Replace the image "overview" or "camera"."""
        self._put(name, jpeg)

    def wait(self) -> None:
        """Wait until the process ends, which it does not by itself."""
        self._process.join()

    def close(self) -> None:
        """Let the page show what it was told last, and end the process."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._sender.is_alive():
            self._sender.join(ENDS)
        self._pipe.close()  # by which it knows
        self._process.join(ENDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _opened(self) -> str:
        try:
            kind, what = self._pipe.recv()
        except (EOFError, OSError):
            self._process.join(ENDS)
            raise LayflatError(f"the page's process is gone (status {self._process.exitcode})") from None
        if kind == "failed":
            problem, where, right = what
            raise InputError(problem, where=where, right=right)
        return str(what)

    def _put(self, kind: str, what: object) -> None:
        with self._changed:
            self._newest[kind] = what
            self._changed.notify()

    def _send(self) -> None:
        """Send the newest of each kind, as fast as they are read."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._newest or self._closed)
                newest, self._newest = self._newest, {}
            if not newest:
                return
            try:
                for item in newest.items():
                    self._pipe.send(item)
            except OSError:  # the process is gone; the run goes on
                return
