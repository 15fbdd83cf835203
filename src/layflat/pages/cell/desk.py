"""State that all pages of a run share: its newest snapshot and images, and people's requests."""

from multiprocessing.connection import Connection
from threading import Thread

from fastapi import Response
from nicegui import app

from layflat.pages.cell.snapshot import About, Requests, Snapshot
from layflat.pages.look.rounds import Rounds

IMAGES = ("overview", "camera")


class Desk:
    """The desk behind all pages of a run.

    Attributes:
        about: what the run is of.
        asked: what people ask of it.
        snapshot: the newest.
        numbers: of the newest images, from 1; 0 where there is none.
        rounds: show all pages what is so.
        over: whether there is nobody any more who tells of the run.
    """

    def __init__(self, about: About, asked: Requests) -> None:
        self.about, self.asked, self.snapshot, self.over = about, asked, Snapshot(), False
        self.numbers = dict.fromkeys(IMAGES, 0)
        self.rounds = Rounds()
        self._images: dict[str, bytes] = {}

    def follow(self, pipe: Connection) -> None:
        """Take what comes, in a thread of its own, and serve images to those who may see the pages."""
        app.get("/run/{name}.jpg")(self._image)
        Thread(target=self._read, args=(pipe,), daemon=True).start()

    def take(self, kind: str, what: object) -> None:
        """Take a snapshot, or an image by its name."""
        if isinstance(what, Snapshot):
            self.snapshot = what
        elif isinstance(what, bytes):
            self._images[kind] = what
            self.numbers[kind] += 1

    def _read(self, pipe: Connection) -> None:
        try:
            while True:
                self.take(*pipe.recv())
        except (EOFError, OSError):
            self.over = True

    def _image(self, name: str) -> Response:
        image = self._images.get(name)
        if image is None:
            return Response(status_code=404)
        return Response(image, media_type="image/jpeg", headers={"cache-control": "no-store"})
