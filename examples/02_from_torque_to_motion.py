"""From what a joint shall do to a joint that moves: size it, draw its cam, simulate it. Writes build/examples/02*."""

from pathlib import Path

from layflat import rollout, size_joint
from layflat.design import SizingRequest, write_drawings
from layflat.plot.runs import angles
from layflat.plot.style import save

OUT = Path("build/examples")

sized = size_joint(SizingRequest.from_text(torque="40 N m", stroke="110 deg", supply="5 bar", name="shoulder"))
design = sized.design
print(f"{1e3 * design.joint.hose.width:.0f} mm hose on a {1e3 * design.joint.cylinder.diameter:.0f} mm cylinder")
print(f"{design.mean_torque:.1f} N m, strap safety {min(s.safety for s in design.stresses):.2f}")
for path in [sized.write(OUT / "02-shoulder.toml"), *write_drawings(design, OUT)]:
    print(f"wrote {path}")

run = rollout(sized.machine, [("0 s", "-20 deg"), ("0.5 s", "20 deg")], duration="3 s")
save(angles({"sized joint": run}, design.name), OUT / "02.png")
