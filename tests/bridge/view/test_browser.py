import socket
import time
from collections.abc import Iterator
from math import radians
from typing import Any
from urllib.request import urlopen

import numpy as np
import pytest

from layflat.bridge.view.browser import PlayedMotion, Viewer
from layflat.errors import InputError
from layflat.machine import load
from tests.physics.arms.chain.chains import random_arm

viser: Any = pytest.importorskip("viser")
zstandard: Any = pytest.importorskip("zstandard")

ARM = load("paper-arm")
RUN = PlayedMotion(np.linspace(0.0, 2.0, 201), np.linspace([0.0, 0.0], [radians(40.0), radians(-20.0)], 201))


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    with Viewer(ARM, [0.1, -0.2], port=0) as made:
        yield made


def messages(address: str) -> str:
    """What a browser is sent that opens the page, up to the first slider."""
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    found, until = "", time.monotonic() + 30.0
    protocol = Subprotocol(f"viser-v{viser.__version__}")
    with connect(address.replace("http", "ws"), subprotocols=[protocol], max_size=None) as page:
        while "GuiSlider" not in found and time.monotonic() < until:
            sent = bytes(page.recv(timeout=30.0))  # type: ignore[arg-type]
            packed = sent[16 : 16 + int.from_bytes(sent[8:16], "little")]  # after two sizes of eight bytes each
            found += str(zstandard.ZstdDecompressor().decompress(packed))
    return found


def test_the_page_is_served_on_this_machine_alone(viewer: Viewer) -> None:
    host, port = viewer.address.removeprefix("http://").split(":")
    assert host == "127.0.0.1"
    with urlopen(viewer.address, timeout=30) as page:
        assert page.status == 200
        assert b"<html" in page.read().lower()
    with socket.socket() as other:
        assert other.connect_ex(("127.0.0.2", int(port))) != 0


def test_a_browser_is_sent_the_arm_and_its_sliders(viewer: Viewer) -> None:
    text = messages(viewer.address)
    assert "/arm/1-large/" in text
    assert "/arm/3-tool/" in text
    assert "GuiSlider" in text


def test_sliders_turn_the_joints_and_say_where_the_tip_is(viewer: Viewer) -> None:
    assert list(viewer.sliders) == ["large", "small"]
    assert viewer.sliders["small"].value == pytest.approx(np.degrees(-0.2), abs=0.1)
    before = viewer.text.content
    viewer.sliders["large"].value = 65.0
    until = time.monotonic() + 30.0
    while viewer.text.content == before and time.monotonic() < until:
        time.sleep(0.01)
    assert "**large** is beyond its working stroke" in viewer.text.content
    viewer.sliders["large"].value = 70.0
    while "stop" not in viewer.text.content and time.monotonic() < until:
        time.sleep(0.01)
    assert "**large** is at its stop" in viewer.text.content


def test_a_run_is_played_and_begins_anew() -> None:
    with Viewer(ARM, [0.0, 0.0], motion=RUN, port=0) as viewer:
        viewer.advance(1.0)
        until = time.monotonic() + 30.0
        while abs(viewer.sliders["large"].value - 20.0) > 0.1 and time.monotonic() < until:
            time.sleep(0.01)
        assert viewer.sliders["large"].value == pytest.approx(20.0, abs=0.1)
        assert viewer.sliders["small"].value == pytest.approx(-10.0, abs=0.1)
        viewer.speed.value = "2 x"
        viewer.advance(1.0)
        assert viewer.time.value == 0.0
        viewer.playing.value = False
        viewer.advance(1.0)
        assert viewer.time.value == 0.0


def test_serving_ends_when_it_is_to() -> None:
    looks = iter([False, False, True])
    with Viewer(random_arm(4, 1), [0.0] * 4, motion=None, port=0) as viewer:
        viewer.serve(lambda: next(looks))
    assert next(looks, "none left") == "none left"


def test_a_port_in_use_is_told(viewer: Viewer) -> None:
    port = int(viewer.address.rpartition(":")[2])
    with pytest.raises(InputError, match=rf"port: port {port} can't be had \(Address already in use\); give another"):
        Viewer(ARM, [0.0, 0.0], port=port)
