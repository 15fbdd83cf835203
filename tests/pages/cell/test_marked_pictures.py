"""The camera's image for the page: detections as everywhere, and a ring around the chosen one."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit
from layflat.cell.vision import Detection, draw_detections
from layflat.pages.cell.watcher import detection_of, draw_observation, encode_jpeg

ROUND = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)


def seen(x: float, px: tuple[float, float]) -> Detection:
    outline = np.array(px) + 30.0 * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return Detection("tomato", (x, 0.2, 0.03), 0.06, (200.0, 30.0, 20.0), 0.9, outline)


@pytest.fixture
def observation() -> Observation:
    picture = np.full((240, 320, 3), 120, np.uint8)
    return Observation(1.0, (), picture, (seen(0.3, (80.0, 40.0)), seen(0.4, (220.0, 140.0))))


def test_the_chosen_fruit_is_marked_and_no_other(observation: Observation) -> None:
    assert observation.picture is not None
    plain = draw_detections(observation.picture, observation.detections)
    marked = draw_observation(observation, Fruit(0.402, 0.198, 0.06, "tomato", "first"))
    changed = np.argwhere((plain != marked).any(axis=2))
    assert len(changed) > 100
    assert np.linalg.norm(changed - [140, 220], axis=1).max() < 80.0
    assert (observation.picture == 120).all()


def test_a_ring_near_the_edge_has_its_word_below(observation: Observation) -> None:
    assert observation.picture is not None
    plain = draw_detections(observation.picture, observation.detections)
    marked = draw_observation(observation, Fruit(0.3, 0.2, 0.06, "tomato", "first"))
    down = np.argwhere((plain != marked).any(axis=2))[:, 0]
    assert down.max() > 40 + 30 + 20


def test_what_the_image_does_not_show_is_not_marked(observation: Observation) -> None:
    hidden = Fruit(0.34, 0.2, 0.06, "tomato", "first")
    assert detection_of(observation, hidden) is None
    assert (draw_observation(observation, hidden) == draw_observation(observation, None)).all()
    assert detection_of(Observation(0.0, ()), hidden) is None


def test_images_become_small_files(observation: Observation) -> None:
    made = encode_jpeg(draw_observation(observation, None))
    opened = Image.open(BytesIO(made))
    assert (opened.format, opened.size) == ("JPEG", (320, 240))
    assert len(made) < 20_000
