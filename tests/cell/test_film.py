from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.cell.pictures import Film, add_caption
from layflat.errors import InputError, OutputError

Picture = NDArray[np.uint8]


def moving(count: int, height: int = 90, width: int = 120) -> list[Picture]:
    """A red square goes over grey."""
    frames = []
    for k in range(count):
        frame = np.full((height, width, 3), 140, np.uint8)
        frame[30:60, 2 * k : 2 * k + 30] = 200, 20, 10
        frames.append(frame)
    return frames


def shown(path: Path) -> tuple[list[Picture], list[float]]:
    with av.open(str(path)) as film:
        frames = list(film.decode(video=0))
        pictures = [np.asarray(frame.to_ndarray(format="rgb24"), np.uint8) for frame in frames]
        return pictures, [float(frame.time or 0.0) for frame in frames]


def write(path: Path, frames: list[Picture], fault: Exception | None = None) -> None:
    with Film(path) as film:
        for frame in frames:
            film.add(frame)
        if fault is not None:
            raise fault


@pytest.mark.parametrize("suffix", [".mp4", ".gif", ".GIF"])
def test_a_film_shows_what_was_added_when_it_was(tmp_path: Path, suffix: str) -> None:
    path, frames = tmp_path / "folder" / f"film{suffix}", moving(30)
    with Film(path, fps=20) as film:
        for frame in frames:
            film.add(frame)
    seen, times = shown(path)
    assert times == pytest.approx(np.arange(30) / 20)
    for frame, shown_one in zip(frames, seen, strict=True):
        assert np.abs(frame.astype(int) - shown_one).mean() < 3.0
    assert list(path.parent.iterdir()) == [path]


def test_an_mp4_is_what_browsers_play_from_the_begin(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    write(path, moving(5))
    with av.open(str(path)) as opened:
        (stream,) = opened.streams.video
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
    written = path.read_bytes()
    assert written.index(b"moov") < written.index(b"mdat")


def test_the_same_frames_are_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.mp4", "two.mp4", "one.gif", "two.gif"):
        write(tmp_path / name, moving(20))
    for suffix in (".mp4", ".gif"):
        assert (tmp_path / f"one{suffix}").read_bytes() == (tmp_path / f"two{suffix}").read_bytes()


def test_odd_sizes_and_upside_down_views_can_be_filmed(tmp_path: Path) -> None:
    path, frame = tmp_path / "film.mp4", moving(1, 91, 121)[0][::-1]
    write(path, [frame])
    seen = shown(path)[0][0]
    assert seen.shape == (92, 122, 3)
    assert np.abs(seen[:91, :121].astype(int) - frame).mean() < 3.0


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
@pytest.mark.parametrize("frames", [0, 3])
def test_a_film_that_breaks_off_leaves_nothing_and_keeps_what_was_there(
    tmp_path: Path, suffix: str, frames: int
) -> None:
    path = tmp_path / f"film{suffix}"
    path.write_text("an older one")
    with pytest.raises(RuntimeError, match="stopped"):
        write(path, moving(frames), RuntimeError("stopped"))
    assert path.read_text() == "an older one"
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_wrong_is_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"'.avi' is not a kind of file that is written here; give .* \.mp4 or \.gif"):
        Film(tmp_path / "film.avi")
    with pytest.raises(OutputError, match="has no suffix"):
        Film(tmp_path / "film")
    with pytest.raises(InputError, match="fps: 0 is out of range"):
        Film(tmp_path / "film.mp4", fps=0.0)
    with pytest.raises(InputError, match=r"has the shape \(40, 60, 3\), the first frame \(90, 120, 3\)"):
        write(tmp_path / "film.mp4", [*moving(1), *moving(1, 40, 60)])
    with pytest.raises(OutputError, match="the film has no frame"):
        write(tmp_path / "film.mp4", [])
    assert list(tmp_path.iterdir()) == []


def test_a_caption_stands_under_its_frame(tmp_path: Path) -> None:
    frame = moving(1, 360, 480)[0]
    both, left, none = (add_caption(frame, *texts) for texts in (("pick 3", "2.5 s"), ("pick 3", ""), ("", "")))
    for one in (both, left, none):
        assert np.array_equal(one[:360], frame)
        assert one.shape == (380, 480, 3)
    strips = [one[360:].astype(int) for one in (both, left, none)]
    assert strips[2].std() == 0.0
    assert np.array_equal(strips[0][:, :240], strips[1][:, :240])
    assert strips[0][:, 240:].max() - strips[2].max() > 200
    assert np.array_equal(strips[1][:, 240:], strips[2][:, 240:])


def test_a_long_caption_leaves_the_right_one_alone() -> None:
    frame = moving(1, 360, 480)[0]
    short, long = (add_caption(frame, text, "2.5 s")[360:, 442:] for text in ("pick", "pick " * 40))
    assert np.array_equal(short, long)
