"""Open-loop characteristics: hysteresis curves of the rigs and joints (Figs 2 to 5 and 10 to 12)."""

from functools import cached_property
from itertools import pairwise

from layflat.experiments.bench import RIG_NAMES
from layflat.experiments.claim import ClaimQuantity, Evaluation, Experiment, claim
from layflat.sim.sweep import HysteresisLoop, sweep

BAR = 1e5
RIG_PRESSURE = 3 * BAR
PRESSURES = (1 * BAR, 2 * BAR, 3 * BAR, 4 * BAR)
SMALL_SWEEP_FRACTION = 0.05  # of the stroke, in hysteresis curves of small motions
TORQUE_PERCENT = "% of torque"


def hysteresis_percent(curve: HysteresisLoop) -> float:
    """Return the height of a hysteresis curve, % of maximum torque."""
    return 100.0 * curve.hysteresis


class OpenLoopExperiment(Experiment):
    """Hysteresis curves of the rigs by name and pressure (Pa), of axis one, and of the earlier actuator."""

    @cached_property
    def rigs(self) -> dict[str, dict[float, HysteresisLoop]]:
        """Curves of every rig at 1 to 4 bar."""
        return {
            name: {pressure: sweep(rig, "small", pressure) for pressure in PRESSURES}
            for name, rig in self.bench.rigs.items()
        }

    @cached_property
    def unbraked(self) -> HysteresisLoop:
        """Curve of axis one without brake."""
        return self.bench.curve("small", brake=0.0)

    @cached_property
    def braked(self) -> HysteresisLoop:
        """Curve of axis one with its brake."""
        return self.bench.curve("small", brake=self.bench.brake)

    @cached_property
    def earlier(self) -> HysteresisLoop:
        """Curve of the earlier actuator."""
        return self.bench.curve("small", self.bench.earlier)

    @claim("open-loop-hysteresis")
    def hysteresis(self) -> Evaluation:
        """Measure the hysteresis of the earlier actuator, and of the new joint without and with brake, % of torque."""
        before, now, braked = (
            hysteresis_percent(self.earlier),
            hysteresis_percent(self.unbraked),
            hysteresis_percent(self.braked),
        )
        return [
            ClaimQuantity("earlier", before, TORQUE_PERCENT, "25"),
            ClaimQuantity("new", now, TORQUE_PERCENT, "7"),
            ClaimQuantity("new with brake", braked, TORQUE_PERCENT, "25"),
        ], 23.0 <= before <= 27.0 and 6.0 <= now <= 8.0 and 23.0 <= braked <= 27.0

    @claim("loop-character")
    def character(self) -> Evaluation:
        """Compare the curves' heights over a small fraction of the stroke with those over all of it."""
        small = {
            brake: self.bench.curve("small", brake=brake, share=SMALL_SWEEP_FRACTION)
            for brake in (self.bench.brake, 0.0)
        }
        small_earlier = self.bench.curve("small", self.bench.earlier, share=SMALL_SWEEP_FRACTION)
        full = self.braked.height - self.unbraked.height
        kept = small[self.bench.brake].height - small[0.0].height
        # A brake that adds nothing keeps nothing.
        brake = 100.0 * kept / full if full > 1e-6 * self.unbraked.height else 0.0
        earlier = 100.0 * small_earlier.height / self.earlier.height
        return [
            ClaimQuantity("height kept with brake", brake, "%", "all"),
            ClaimQuantity("height kept by the earlier", earlier, "%", "less"),
        ], brake >= 95.0 and earlier <= 60.0

    @claim("rig-variants")
    def variants(self) -> Evaluation:
        """Compare the hysteresis of the rigs with each other, and over pressure."""
        hysteresis = {name: hysteresis_percent(self.rigs[name][RIG_PRESSURE]) for name in RIG_NAMES}
        ordered = ("rig-polyester", "rig-polyester-plate", "rig-kevlar-plate", "rig-shell-steel")
        falling = all(
            all(hysteresis_percent(rig[low]) > hysteresis_percent(rig[high]) for low, high in pairwise(PRESSURES))
            for rig in self.rigs.values()
        )
        plain, paper = hysteresis["rig-polyester"], {"rig-polyester": "21", "rig-shell-steel": "8"}
        return (
            [
                ClaimQuantity(name.removeprefix("rig-"), hysteresis[name], TORQUE_PERCENT, paper.get(name, ""))
                for name in RIG_NAMES
            ],
            19.0 <= plain <= 23.0
            and 7.0 <= hysteresis["rig-shell-steel"] <= 9.0
            and all(hysteresis[a] > hysteresis[b] for a, b in pairwise(ordered))
            and abs(hysteresis["rig-single-thickness"] - plain) <= 1.0
            and abs(hysteresis["rig-polyester-polythene"] - plain) <= 1.0
            and falling,
        )
