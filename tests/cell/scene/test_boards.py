from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.scene.boards import charuco, picture
from layflat.errors import CellError


def test_the_boards_share_no_marker(packing: Cell) -> None:
    one, other = (set(charuco(board).getIds().ravel()) for board in (packing.board, packing.base_marker))
    assert one
    assert not one & other


def test_a_board_is_drawn_black_and_white_without_margin(packing: Cell) -> None:
    drawn = picture(packing.board)
    assert set(np.unique(drawn)) == {0, 255}
    assert drawn.shape[1] * packing.board.rows == drawn.shape[0] * packing.board.columns
    assert drawn[0, 0] == 0


@pytest.mark.parametrize(
    ("update", "said"), [({"dictionary": "DICT_9X9"}, "no dictionary"), ({"first_id": 40}, "only 50 markers")]
)
def test_a_board_that_can_not_be_is_told(packing: Cell, update: dict[str, object], said: str) -> None:
    with pytest.raises(CellError, match=said):
        charuco(packing.board.model_copy(update=update))
