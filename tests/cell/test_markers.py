from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.extras import CharucoBoard, board_picture, make_charuco_board, marker_picture
from layflat.errors import CameraError


def test_markers_are_drawn_as_they_are_read(packing: Cell) -> None:
    cv2: Any = __import__("cv2")
    base = packing.base_markers
    words = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, base.dictionary))
    for marker in base.marker.values():
        drawn = np.pad(marker_picture(base.dictionary, marker.number), 80, constant_values=255)
        _, numbers, _ = cv2.aruco.ArucoDetector(words).detectMarkers(drawn)
        assert numbers.ravel().tolist() == [marker.number]


def test_a_marker_that_no_dictionary_has_is_told() -> None:
    with pytest.raises(CameraError, match="only 50 markers"):
        marker_picture("DICT_5X5_50", 50)


def test_a_board_is_drawn_black_and_white_without_margin(packing: Cell) -> None:
    drawn = board_picture(CharucoBoard(**packing.board.model_dump()))
    assert set(np.unique(drawn)) == {0, 255}
    assert drawn.shape[1] * packing.board.rows == drawn.shape[0] * packing.board.columns
    assert drawn[0, 0] == 0


@pytest.mark.parametrize(
    ("update", "said"), [({"dictionary": "DICT_9X9"}, "unknown dictionary"), ({"first_id": 40}, "only 50 markers")]
)
def test_a_board_that_can_not_be_is_told(packing: Cell, update: dict[str, object], said: str) -> None:
    with pytest.raises(CameraError, match=said):
        make_charuco_board(CharucoBoard(**packing.board.model_dump() | update))
