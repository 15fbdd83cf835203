"""Table 1: every cell rounds to the printed digits with the table's own constants."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from layflat.design import Table1Constants, table1

PRINTED = """
gamma_rad,alpha_rad,A,B,C_m,D,Z,b_deg,T_Nm,work_Nm_deg,move_m,force_N,cam_radius_m,cam_angle_rad,cam_angle_deg,output_torque_Nm
2.094,2.094,0.866325,0.239945,0,1.499658,0.276969,0,109.7463,0,0,4221.011,0.019451,0,0,82.10202
2.094,2.0312,0.866325,0.23109,0.002393,1.44431,0.262758,13.32,104.1153,1424.318,0.006041,4004.433,0.020503,0.302419,17.33612,82.10202
2.094,1.9684,0.866325,0.221954,0.004785,1.38721,0.248539,26.64,98.48103,1349.291,0.012083,3787.732,0.021676,0.588885,33.75773,82.10202
2.094,1.9056,0.866325,0.212573,0.007178,1.328584,0.234366,39.96,92.86506,1274.365,0.018124,3571.733,0.022987,0.85942,49.26609,82.10202
2.094,1.8428,0.866325,0.202986,0.009571,1.268662,0.220291,53.28,87.28828,1199.821,0.024165,3357.242,0.024455,1.114105,63.86587,82.10202
2.094,1.78,0.866325,0.193229,0.011963,1.207681,0.206367,66.6,81.77094,1125.934,0.030207,3145.036,0.026105,1.35308,77.56511,82.10202
2.094,1.7172,0.866325,0.183341,0.014356,1.145881,0.192642,79.92,76.33252,1052.969,0.036248,2935.866,0.027965,1.576543,90.37506,82.10202
2.094,1.6544,0.866325,0.173361,0.016749,1.083506,0.179163,93.24,70.99169,981.1792,0.04229,2730.449,0.030069,1.784743,102.3101,82.10202
2.094,1.5916,0.866325,0.163328,0.019141,1.020802,0.165976,106.56,65.76616,910.8072,0.048331,2529.468,0.032458,1.977982,113.3875,82.10202
2.094,1.5288,0.866325,0.153283,0.021534,0.958016,0.153121,119.88,60.67268,842.0827,0.054372,2333.565,0.035183,2.156611,123.6274,82.10202
2.094,1.466,0.866325,0.143263,0.023927,0.895395,0.140639,133.2,55.72693,775.2214,0.060414,2143.343,0.038306,2.321027,133.0525,82.10202
""".strip()  # as printed, but for a misread digit in column D of the last two rows

ROWS = [line.split(",") for line in PRINTED.splitlines()]


@pytest.mark.parametrize("column", range(len(ROWS[0])), ids=ROWS[0])
def test_every_cell_rounds_to_the_printed_digits(column: int) -> None:
    name = ROWS[0][column]
    values = table1().columns[name]
    for row, value in zip(ROWS[1:], values, strict=True):
        printed = row[column]
        digits = len(printed.partition(".")[2])
        assert round(float(value), digits) == pytest.approx(float(printed), abs=10.0 ** -(digits + 3)), name


def test_columns_stand_in_the_printed_order() -> None:
    assert list(table1().columns) == ROWS[0]


def test_mean_torque_rounds_to_the_printed_one() -> None:
    assert f"{table1().mean_torque:.5f}" == "82.10202"


def test_intermediate_values_make_the_torque() -> None:
    t, k = table1().columns, Table1Constants()
    np.testing.assert_allclose(t["Z"], (t["B"] - t["C_m"] * t["D"]) / t["A"], rtol=1e-14)
    np.testing.assert_allclose(t["T_Nm"], t["Z"] * k.pressure * k.cylinder_radius * k.roller_radius / 2, rtol=1e-14)


def test_true_pi_with_the_printed_hose_radius_gives_the_mean_of_the_notes() -> None:
    true = table1(Table1Constants(hose_width=0.16 * pi / 3.14, pi=pi))
    assert round(true.mean_torque, 2) == 82.18
