"""Linear model beside the plant's own response and the margins of the control law, as figure and tables."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.arrays import Array
from layflat.files import write_text
from layflat.linear.loop import LoopMargins, loop_margins, measure_loops
from layflat.linear.response import DEFAULT_FREQUENCIES, deviations_growth, measure_response

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINE_FREQUENCIES = np.geomspace(0.2, 40.0, 400)  # of the drawn model, Hz
PASCAL_PER_BAR = 1e5


@dataclass(frozen=True)
class BodeComparison:
    """Responses of a linear model, of its plant, and of the loops of the machine's control law.

    Attributes:
        model: of `linearize`.
    """

    model: Any

    @cached_property
    def growth(self) -> float:
        """Rate at which deviations grow, 1/s: joints do not slide steadily, and have no response to measure; else 0."""
        return deviations_growth(self.model)

    @cached_property
    def plant(self) -> Any:
        """Response of the simulated plant to the valves' voltages; None where joints do not slide steadily."""
        return None if self.growth else measure_response(self.model)

    @cached_property
    def loops(self) -> Any:
        """Loops of the control law; None for a machine without one."""
        return None if self.model.operating_point.machine.controller is None else measure_loops(self.model)

    @cached_property
    def margins(self) -> dict[str, LoopMargins | None]:
        """Margins of the loops by joint, None of one that does not settle; empty without a control law."""
        return {} if self.loops is None else loop_margins(self.loops)

    def closes_loop(self, joint: str) -> bool:
        """Return whether the control law regulates a joint there, which it may leave to friction."""
        j = self.joints.index(joint)
        return bool(self.loops.frdata[j, j].any())

    @property
    def joints(self) -> list[str]:
        """Names of the joints."""
        return list(self.model.operating_point.machine.joints)

    def output_of(self, joint: str) -> str:
        """Return the output that shows a joint's response: its velocity, or its pressure where it is held."""
        velocity = f"{joint}_velocity"
        return velocity if velocity in self.model.output_labels else f"{joint}_differential_pressure"

    def errors(self) -> dict[str, tuple[float, float]]:
        """Return the largest errors of the model's gain and phase (fraction, deg), if the plant is measured."""
        errors = {}
        for joint in self.joints if self.plant is not None else ():
            measured, modelled = self._pair(joint)
            ratio = modelled / measured
            errors[joint] = float(np.abs(np.abs(ratio) - 1.0).max()), float(np.degrees(np.abs(np.angle(ratio))).max())
        return errors

    def _pair(self, joint: str) -> tuple[Array, Array]:
        """Return a joint's response in the plant and in the model, at the frequencies of the plant's."""
        output, voltage = self.output_of(joint), f"{joint}_voltage"
        measured = self.plant.frdata[self.plant.output_labels.index(output), self.plant.input_labels.index(voltage)]
        return measured, self.model[output, voltage](1j * self.plant.omega)

    def plot(self) -> "Figure":
        """Draw gain and phase of model and plant, and of the loops."""
        from layflat.plot.bode import Responses, bode_figure  # noqa: PLC0415

        columns: dict[str, dict[str, Responses]] = {}
        for joint in self.joints:
            output = self.output_of(joint)
            slides = output.endswith("velocity")
            heading = "Velocity (deg/s per V)" if slides else "Differential pressure (bar per V)"
            scale = np.degrees(1.0) if slides else 1.0 / PASCAL_PER_BAR
            line = scale * self.model[output, f"{joint}_voltage"](2j * np.pi * LINE_FREQUENCIES)
            points = None if self.plant is None else (self.plant.omega / (2.0 * np.pi), scale * self._pair(joint)[0])
            columns.setdefault(heading, {})[joint] = Responses((LINE_FREQUENCIES, line), points)
        if self.loops is not None:
            f = self.loops.omega / (2.0 * np.pi)
            drawn = {joint: self.loops.frdata[j, j] for j, joint in enumerate(self.joints) if self.margins[joint]}
            loops = {joint: Responses((f, loop)) for joint, loop in drawn.items() if self.closes_loop(joint)}
            columns |= {"Loop with the control law (1)": loops} if loops else {}
        return bode_figure(columns)

    def save_table(self, path: Path) -> Path:
        """Write the responses of model and plant, a row for each frequency and joint, as CSV; return the path."""
        rows = ["frequency (Hz),joint,output,unit,model gain,model phase (deg),plant gain,plant phase (deg)"]
        for joint in self.joints:
            output = self.output_of(joint)
            unit = f"{self.model.units[output]} per V"
            w = 2.0 * np.pi * np.array(DEFAULT_FREQUENCIES)
            modelled = self.model[output, f"{joint}_voltage"](1j * w)
            measured = np.full(len(w), np.nan) if self.plant is None else self._pair(joint)[0]
            for frequency, *pair in zip(DEFAULT_FREQUENCIES, modelled, measured, strict=True):
                numbers = ",".join(f"{abs(value):.6g},{np.degrees(np.angle(value)):.3f}" for value in pair)
                rows.append(f"{frequency:g},{joint},{output},{unit},{numbers}")
        return write_text(path, "\n".join(rows) + "\n")
