"""Videos of one camera: episodes one behind the other in files that LeRobot's loader can seek in."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Picture
from layflat.errors import InputError
from layflat.lerobot.layout import BYTES_PER_MIB, MAX_VIDEO_FILE, VIDEO_PATH, CameraFeature, FileNumber

CODEC_NAME = "libsvtav1"  # encoder of AV1, LeRobot's own
CODEC_OPTIONS = {"g": "2", "crf": "30", "preset": "12"}  # LeRobot's: every other picture can be decoded by itself
# From 1024 s on the loader may refuse frames of an episode that does not begin its file (findings/lerobot-*.sh).
MAX_EPISODE_START = 512.0  # of an episode in a file, which leaves it as much; a later one begins a new file, s


class CameraVideo:
    """Video of a camera, picture by picture; `close` ends its last file.

    Args:
        folder: of the data set.
        key: name of the camera's feature.
        camera: size of its pictures.
        fps: pictures a second.
    """

    def __init__(self, folder: Path, key: str, camera: CameraFeature, fps: int) -> None:
        """Load the encoder; a file begins with its first picture."""
        self._av = extras.import_extra("cell", "av", where=key)
        os.environ.setdefault("SVT_LOG", "1")  # else the encoder prints its settings
        self._folder, self._key, self._camera, self._fps = folder, key, camera, fps
        self._number: FileNumber | None = None
        self._file: Any = None
        self._stream: Any = None
        self._pictures = self._episode_start = 0  # of this file

    def start_episode(self) -> None:
        """Start an episode at the next picture, in a new file where this one is large or long enough."""
        if self._file is not None:
            path = Path(self._file.name)
            long = self._pictures > MAX_EPISODE_START * self._fps
            size = path.stat().st_size if path.exists() else 0  # the encoder holds the first pictures back
            if long or size > MAX_VIDEO_FILE * BYTES_PER_MIB:
                self.close()
        self._episode_start = self._pictures if self._file is not None else 0

    def add(self, picture: Picture) -> None:
        """Encode a picture, (H, W, 3) RGB; raise InputError unless it has the camera's size."""
        if picture.shape != (self._camera.height, self._camera.width, 3):
            what = f"has the shape {picture.shape}, the first picture ({self._camera.height}, {self._camera.width}, 3)"
            raise InputError(what, where=self._key, right="give all pictures of a camera one size")
        if self._file is None:
            self._open()
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        frame.pts = self._pictures
        self._pictures += 1
        self._file.mux(self._stream.encode(frame))

    @property
    def episode_place(self) -> dict[str, int | float]:
        """Place of the present episode, as the table of episodes has it: file, and times in it, s."""
        number = self._number or FileNumber()
        place = {"chunk_index": number.chunk_index, "file_index": number.file_index}
        times = {"from_timestamp": self._episode_start / self._fps, "to_timestamp": self._pictures / self._fps}
        return {f"videos/{self._key}/{name}": value for name, value in (place | times).items()}

    @property
    def episode_pictures(self) -> int:
        """Count of pictures in the present episode."""
        return self._pictures - self._episode_start

    def close(self) -> None:
        """Finish the present file, if there is one."""
        if self._file is not None:
            self._file.mux(self._stream.encode())
            self._file.close()
        self._file, self._pictures = None, 0

    def _open(self) -> None:
        """Open the next file."""
        self._number = self._number.following() if self._number is not None else FileNumber()
        path = self._folder / VIDEO_PATH.format(video_key=self._key, **self._number._asdict())
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self._av.open(str(path), "w")
        self._stream = self._file.add_stream(CODEC_NAME, rate=self._fps, options=CODEC_OPTIONS)
        self._stream.pix_fmt = "yuv420p"
        self._stream.width, self._stream.height = self._camera.width, self._camera.height
