"""Draw the hysteresis curves of every built-in kind of losses, at three sizes of motion, into docs/hysteresis.png.

The torque of one hose at 3 bar is drawn, whose losses oppose a large slow motion with 1 N m. Rate-dependent kinds are
rotated once a second, with elements that slip.
"""

from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from layflat.physics.hysteresis import HYSTERESIS, at_rest, torques, turned
from layflat.plot.style import SERIES_STYLES, save_figure, styled_figure

PRESSURE = {"reference_pressure_gauge": "3 bar", "pressure_free": 0.25}
SLIP = {"kind": "elasto-slip", "deflections": ["1 deg", "4 deg", "12 deg"], "weights": [0.4, 0.3, 0.3]}
MAXWELL = {"kind": "maxwell", "deflection": "4 deg", "times": ["0.1 s"], "weights": [0.4]}
CREEP = {"kind": "creep", "deflection": "4 deg", "per_decade": 0.1, "first": "10 ms", "last": "100 s"}
SHOWN: dict[str, dict[str, Any]] = {
    "elasto-slip": SLIP,
    "elasto-slip-spectrum": {"kind": "elasto-slip-spectrum", "first": "0.3 deg", "last": "12 deg", "elements": 12},
    "bouc-wen": {"kind": "bouc-wen", "deflection": "3 deg", "beta": 0.9},
    "elasto-slip and maxwell": {"kind": "parallel", "parts": {"slip": SLIP, "rate": MAXWELL}},
    "elasto-slip and creep": {"kind": "parallel", "parts": {"slip": SLIP, "rate": CREEP}},
}
SIZES, POINTS = (20.0, 8.0, 2.0), 500  # half of each motion, deg; instants of a cycle


def curve(described: dict[str, Any], size: float) -> tuple[Any, Any]:
    """Return angle (rad) and torque (N m) over the last of three cycles.

    Args:
        described: losses, as in a description file.
        size: half of the motion, deg.
    """
    part = HYSTERESIS.named(described["kind"]).description.model_validate(described | PRESSURE)
    loss = HYSTERESIS.parameters(part, 1.0)
    angle = radians(size) * np.sin(2 * np.pi * np.arange(3 * POINTS + 1) / POINTS)
    state, torque = at_rest(loss), [0.0]
    for turn in np.diff(angle):
        state = turned(loss, state, float(turn), 3e5, 1.0 / POINTS)
        torque.append(sum(torques(loss, state)))
    return angle[-POINTS - 1 :], np.array(torque)[-POINTS - 1 :]


def main(path: Path) -> None:
    """Draw torque over angle, one plot for each kind and one line for each size of motion, into a file."""
    with styled_figure(1, len(SHOWN), width=10.0, height=3.1, above=0.6, between=0.42) as (figure, axes):
        for place, (name, described) in zip(axes, SHOWN.items(), strict=True):
            for line, size in zip(SERIES_STYLES, SIZES, strict=False):
                angle, torque = curve(described, size)
                place.plot(np.degrees(angle), torque, label=f"±{size:g} deg", **line)
            place.set_title(name.replace(" and ", "\nand "), fontsize=9)
            place.set_xlabel("Angle (deg)")
        axes[0].set_ylabel("Torque of the losses (N m)")
        figure.legend(*axes[0].get_legend_handles_labels(), ncols=3, loc="upper left")
        save_figure(figure, path)


if __name__ == "__main__":
    main(Path(__file__).with_suffix(".png"))
