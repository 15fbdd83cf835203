"""Open-loop characteristics: hysteresis curves of the rigs and joints (Figs 2 to 5 and 10 to 12)."""

from functools import cached_property
from itertools import pairwise

from layflat.experiments.bench import RIGS
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.sim.sweep import Loop, sweep

BAR = 1e5
RIG_PRESSURE = 3 * BAR
PRESSURES = (1 * BAR, 2 * BAR, 3 * BAR, 4 * BAR)
SMALL_SWEEP = 0.05  # share of the stroke over which hysteresis curves of small motions are compared
OF_TORQUE = "% of torque"


def percent(curve: Loop) -> float:
    """Return the height of a curve, % of greatest torque."""
    return 100.0 * curve.hysteresis


class OpenLoop(Experiment):
    """Hysteresis curves of the rigs by name and pressure (Pa), of axis one, and of the earlier actuator."""

    @cached_property
    def rigs(self) -> dict[str, dict[float, Loop]]:
        """Every rig at 1 to 4 bar."""
        return {
            name: {pressure: sweep(rig, "small", pressure) for pressure in PRESSURES}
            for name, rig in self.bench.rigs.items()
        }

    @cached_property
    def unbraked(self) -> Loop:
        """Axis one without brake."""
        return self.bench.curve("small", brake=0.0)

    @cached_property
    def braked(self) -> Loop:
        """Axis one with its brake."""
        return self.bench.curve("small", brake=self.bench.brake)

    @cached_property
    def earlier(self) -> Loop:
        """The earlier actuator."""
        return self.bench.curve("small", self.bench.earlier)

    @claim("open-loop-hysteresis")
    def hysteresis(self) -> Evaluated:
        """Compare the height of the curves."""
        before, now, braked = percent(self.earlier), percent(self.unbraked), percent(self.braked)
        return [
            Quantity("earlier", before, OF_TORQUE, "25"),
            Quantity("new", now, OF_TORQUE, "7"),
            Quantity("new with brake", braked, OF_TORQUE, "25"),
        ], 23.0 <= before <= 27.0 and 6.0 <= now <= 8.0 and 23.0 <= braked <= 27.0

    @claim("loop-character")
    def character(self) -> Evaluated:
        """Compare what is left of the curves' height over a small part of the stroke."""
        small = {brake: self.bench.curve("small", brake=brake, share=SMALL_SWEEP) for brake in (self.bench.brake, 0.0)}
        small_earlier = self.bench.curve("small", self.bench.earlier, share=SMALL_SWEEP)
        full = self.braked.height - self.unbraked.height
        kept = small[self.bench.brake].height - small[0.0].height
        # A brake that adds nothing keeps nothing.
        brake = 100.0 * kept / full if full > 1e-6 * self.unbraked.height else 0.0
        earlier = 100.0 * small_earlier.height / self.earlier.height
        return [
            Quantity("height kept with brake", brake, "%", "all"),
            Quantity("height kept by the earlier", earlier, "%", "less"),
        ], brake >= 95.0 and earlier <= 60.0

    @claim("rig-variants")
    def variants(self) -> Evaluated:
        """Compare the rigs."""
        at = {name: percent(self.rigs[name][RIG_PRESSURE]) for name in RIGS}
        ordered = ("rig-polyester", "rig-polyester-plate", "rig-kevlar-plate", "rig-shell-steel")
        falling = all(
            all(percent(rig[low]) > percent(rig[high]) for low, high in pairwise(PRESSURES))
            for rig in self.rigs.values()
        )
        plain, given = at["rig-polyester"], {"rig-polyester": "21", "rig-shell-steel": "8"}
        return (
            [Quantity(name.removeprefix("rig-"), at[name], OF_TORQUE, given.get(name, "")) for name in RIGS],
            19.0 <= plain <= 23.0
            and 7.0 <= at["rig-shell-steel"] <= 9.0
            and all(at[a] > at[b] for a, b in pairwise(ordered))
            and abs(at["rig-single-thickness"] - plain) <= 1.0
            and abs(at["rig-polyester-polythene"] - plain) <= 1.0
            and falling,
        )
