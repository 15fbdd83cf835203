"""State that all pages of a run share: its newest snapshot and images, and people's requests."""

from multiprocessing.connection import Connection
from threading import Thread

from fastapi import Response
from nicegui import app

from layflat.pages.cell.snapshot import RunRequests, RunSnapshot, RunSubject
from layflat.pages.look.pieces import Rounds

IMAGE_NAMES = ("overview", "camera")


class RunFeed:
    """Newest snapshot and images of a run, received from its process, and people's requests to it.

    Attributes:
        about: subject of the run.
        requests: people's requests to the run, in shared memory.
        snapshot: newest snapshot.
        numbers: counts of the images received, by image name; 0 before the first.
        rounds: refresh of all open pages.
        is_over: whether the run's process has closed the pipe.
    """

    def __init__(self, about: RunSubject, requests: RunRequests) -> None:
        """Begin without images, with the snapshot of a run that has not begun."""
        self.about, self.requests, self.snapshot, self.is_over = about, requests, RunSnapshot(), False
        self.numbers = dict.fromkeys(IMAGE_NAMES, 0)
        self.rounds = Rounds()
        self._images: dict[str, bytes] = {}

    def follow(self, pipe: Connection) -> None:
        """Receive messages from a pipe in a thread of its own, and serve the images under `/run/NAME.jpg`."""
        app.get("/run/{name}.jpg")(self._image_response)
        Thread(target=self._receive, args=(pipe,), daemon=True).start()

    def store(self, kind: str, what: object) -> None:
        """Store a snapshot, or an image (JPEG) of the name `kind`, which is counted in `numbers`; ignore all else."""
        if isinstance(what, RunSnapshot):
            self.snapshot = what
        elif isinstance(what, bytes):
            self._images[kind] = what
            self.numbers[kind] += 1

    def _receive(self, pipe: Connection) -> None:
        """Store snapshots and images from the pipe until the run closes it; then the feed is over."""
        try:
            while True:
                self.store(*pipe.recv())
        except (EOFError, OSError):
            self.is_over = True

    def _image_response(self, name: str) -> Response:
        """Return the response with the newest image of a name (JPEG, never stored), or status 404 if there is none."""
        image = self._images.get(name)
        if image is None:
            return Response(status_code=404)
        return Response(image, media_type="image/jpeg", headers={"cache-control": "no-store"})
