"""Process that serves the page of a run, and the run's link to it: the run sends snapshots and never waits."""

from contextlib import AbstractContextManager
from dataclasses import replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Condition, Thread
from typing import Any

from layflat.errors import InputError, LayflatError
from layflat.pages.cell.snapshot import RunRequests, RunSnapshot, RunSubject
from layflat.pages.server.place import Endpoint
from layflat.pages.server.serve import serve
from layflat.parallel import end_process, start_process

EXIT_TIMEOUT = 5.0  # for the page's process to end once the pipe is closed, s


def serve_run(about: RunSubject, place: Endpoint, pipe: Connection, requests: RunRequests) -> None:
    """Serve the page of a run until the other side of the pipe is closed: main function of the page's process.

    The first message to the run is ("ready", start link), or ("failed", fields of the InputError).

    Args:
        about: subject of the run.
        place: endpoint at which the page is served.
        pipe: pipe to and from the run.
        requests: people's requests, in memory that both processes share.
    """
    from layflat.pages.cell.desk import RunFeed  # noqa: PLC0415  # they need the extra
    from layflat.pages.cell.page import run_page  # noqa: PLC0415

    feed = RunFeed(about, requests)
    try:
        serve(
            lambda: run_page(feed),
            place,
            title=f"layflat: {about.cell}",
            started=lambda: feed.follow(pipe),
            ready=lambda link: pipe.send(("ready", link)),
            stopped=lambda: feed.is_over,
        )
    except InputError as error:
        pipe.send(("failed", (error.what, error.where, error.right)))


class PageLink(AbstractContextManager["PageLink"]):
    """Link of a run to the process of its page: starts it, and ends it at the end of a `with` block.

    The constructor waits until the page is served. It raises InputError if the endpoint can't be used, and LayflatError
    if the process ends before that.

    Attributes:
        link: start link of the page.
        requests: people's requests to the run.
        snapshot: snapshot that was sent last.
    """

    def __init__(self, about: RunSubject, place: Endpoint) -> None:
        """Start the page's process and wait until the page is served; the process is ended if that fails."""
        self.requests, self.snapshot = RunRequests.shared(), RunSnapshot()
        self._pipe, its = Pipe()
        self._newest: dict[str, object] = {}
        self._changed, self._closed = Condition(), False
        self._process = start_process(serve_run, (about, place, its, self.requests), "layflat-page", daemon=True)
        its.close()
        self._sender = Thread(target=self._send, name="layflat-page", daemon=True)
        try:
            self.link = self._await_address()
            self._sender.start()
        except BaseException:
            self.close()
            raise

    def show(self, **changes: Any) -> None:
        """Change fields of the snapshot, and queue it for the page in place of one that was not sent yet."""
        self.snapshot = replace(self.snapshot, **changes)
        self._post("snapshot", self.snapshot)

    def image(self, name: str, jpeg: bytes) -> None:
        """Queue the image "overview" or "camera" for the page, in place of one that was not sent yet."""
        self._post(name, jpeg)

    def wait(self) -> None:
        """Wait until the page's process is ended from outside."""
        self._process.join()

    def close(self) -> None:
        """Send the last messages, for which `EXIT_TIMEOUT` is allowed, and end the process."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._sender.is_alive():
            self._sender.join(EXIT_TIMEOUT)
        self._pipe.close()  # by which it notices
        end_process(self._process, EXIT_TIMEOUT)

    def __exit__(self, *_: object) -> None:
        self.close()

    def _await_address(self) -> str:
        """Return the address of the page once its process serves it.

        Raises:
            InputError: the process can't serve the page.
            LayflatError: the process has ended before that.
        """
        try:
            kind, what = self._pipe.recv()
        except (EOFError, OSError):
            self._process.join(EXIT_TIMEOUT)
            status = self._process.exitcode
            raise LayflatError(f"the page's process has ended (status {status}): start the run again") from None
        if kind == "failed":
            problem, where, right = what
            raise InputError(problem, where=where, right=right)
        return str(what)

    def _post(self, kind: str, what: object) -> None:
        """Queue a message for the sender, in place of one of its kind that was not sent yet; return at once."""
        with self._changed:
            self._newest[kind] = what
            self._changed.notify()

    def _send(self) -> None:
        """Send the newest message of each kind, as fast as the page's process reads them, until closed."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._newest or self._closed)
                newest, self._newest = self._newest, {}
            if not newest:
                return
            try:
                for item in newest.items():
                    self._pipe.send(item)
            except OSError:  # the process has ended; the run continues
                return
