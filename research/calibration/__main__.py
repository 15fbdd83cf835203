"""Find what the paper leaves open: `python -m research.calibration --seed 1 --minutes 25 [--write]`.

First axis one and the earlier actuator, which share a controller; then the large joint, in the arm. The same seed
finds the same if the time suffices. With --write the values go into the built-in descriptions, as calibrated.
"""

import argparse
import sys

from layflat.experiments.reproduction import reproduce
from research.calibration.stages import calibrate_machines, describe_shortfalls, stages
from research.calibration.unknowns import LOSSES
from research.calibration.written import loss_shares, write_loss_shares, write_values


def main() -> None:
    """Search, check by all claims, and write if asked to."""
    asked = argparse.ArgumentParser(prog="python -m research.calibration", description=__doc__)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--minutes", type=float, default=25.0, help="time for the whole search")
    asked.add_argument("--kind", choices=sorted(LOSSES), default="elasto-slip", help="of losses")
    asked.add_argument("--anew", action="store_true", help="begin anywhere, not at what stands in the descriptions")
    asked.add_argument("--write", action="store_true", help="put the values into the built-in descriptions")
    given = asked.parse_args()
    if given.write:
        write_loss_shares(loss_shares())
    on, texts, found = calibrate_machines(given.kind, given.seed, given.minutes, anew=given.anew)
    lines = [
        f"{stage.name}: short of {describe_shortfalls(best.lacks)}; "
        f"descent {best.descent}, generation {best.generation}"
        for stage, best in zip(stages(given.kind), found, strict=True)
    ]
    done = reproduce(on)
    wrong = [claim.id for claim in done.claims if claim.agrees is False]
    lines.append(done.summary + (f": not {', '.join(wrong)}" if wrong else ""))
    lines += [f"{path} = {text}" for own in texts for path, text in own.items()]
    sys.stdout.write("\n".join(lines) + "\n")
    if given.write:
        axis_one, arm = texts
        # The controller of section 4.1 is that of the earlier actuator; the arm was tuned by itself.
        write_values("paper-small-joint", {path: text for path, text in axis_one.items() if ".gains." in path})
        write_values("paper-arm", axis_one | arm)


if __name__ == "__main__":
    main()
