from dataclasses import replace

import numpy as np

from layflat.design import table1
from layflat.experiments.statics import printed_table, wrong_cells


def test_every_cell_of_table_1_rounds_to_the_printed_digits() -> None:
    assert wrong_cells(table1()) == []
    assert sum(map(len, printed_table().values())) == 176


def test_a_wrong_cell_is_found() -> None:
    table = table1()
    bent = table.T_Nm.copy()
    bent[3] += 1e-4
    assert wrong_cells(replace(table, T_Nm=bent)) == ["T_Nm, row 4"]


def test_the_printed_table_is_whole() -> None:
    assert all(len(column) == 11 for column in printed_table().values())
    assert np.isfinite([float(cell) for column in printed_table().values() for cell in column]).all()
