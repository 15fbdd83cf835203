"""Files of robots for tests: a URDF of two joints whose every part can be put in another's place, and an MJCF."""

from pathlib import Path

BASE = '<link name="base"/>'
UPPER = """<link name="upper">
  <inertial><origin xyz="0.1 0.02 0" rpy="0.1 0.2 0.3"/><mass value="0.5"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.0025" ixy="0.0001" ixz="-0.0002" iyz="0"/></inertial>
  <visual><origin xyz="0.1 0 0" rpy="0 1.5707963 0"/>
    <geometry><cylinder radius="0.02" length="0.2"/></geometry></visual>
  <collision><geometry><box size="0.2 0.1 0.1"/></geometry></collision>
</link>"""
FLANGE = """<link name="flange"><inertial><mass value="0.2"/>
  <inertia ixx="0.0001" iyy="0.0001" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
LOWER = """<link name="lower"><inertial><origin xyz="0 0 0.1"/><mass value="0.3"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.0002" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
TOOL = '<link name="tool0"/>'
LINKS = {"base": BASE, "upper": UPPER, "flange": FLANGE, "lower": LOWER, "tool0": TOOL}


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


SHOULDER = joint(
    "shoulder", "revolute", "base", "upper",
    '<origin xyz="0 0 0.3" rpy="0.2 0 0"/><axis xyz="0 0.6 0.8"/>'
    '<limit lower="-0.2" upper="1.4" effort="9" velocity="2"/>',
)  # fmt: skip
BOLTS = joint("bolts", "fixed", "upper", "flange", '<origin xyz="0.25 0 0" rpy="0 0.5 0"/>')
ELBOW = joint(
    "elbow", "revolute", "flange", "lower",
    '<origin xyz="0 0 0.05" rpy="1.5707963267948966 0 0"/><axis xyz="0 0 2"/>'
    '<limit lower="-1" upper="1" effort="9" velocity="2"/>',
)  # fmt: skip
END = joint("end", "fixed", "lower", "tool0", '<origin xyz="0 0.03 0.2" rpy="0 0 0.7"/>')
JOINTS = {"shoulder": SHOULDER, "bolts": BOLTS, "elbow": ELBOW, "end": END}


def urdf(more: str = "", **parts: str) -> str:
    """A robot of two joints, with other parts where they are given by name, and more."""
    return f'<robot name="two">{"".join((LINKS | JOINTS | parts).values())}{more}</robot>'


def written(folder: Path, text: str, name: str = "robot.urdf") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


MJCF = """
<mujoco model="branching">
  <compiler angle="degree" autolimits="true"/>
  <default><joint damping="0.1" armature="0.003"/><geom density="700"/></default>
  <option gravity="1 2 -9"/>
  <worldbody>
    <geom type="plane" size="1 1 .1"/>
    <body name="post" pos="0 0 .2" euler="0 0 30">
      <geom type="box" size=".05 .05 .1"/>
      <body name="arm" pos="0 0 .1">
        <joint name="swing" axis="0 1 1" pos=".02 0 .01" range="-50 40" ref="10"/>
        <geom type="capsule" fromto="0 0 0 .2 0 0" size=".02"/><geom type="ellipsoid" size=".02 .03 .02"/>
        <body name="fore" pos=".2 0 0" axisangle="1 0 0 40">
          <joint name="bend" axis="1 0 0" range="-60 60"/>
          <geom type="box" size=".02 .02 .1" pos="0 0 .1"/><site name="grip" pos="0 0 .2" euler="0 90 0"/>
          <body name="finger" pos="0 .02 .2"><joint name="close" type="slide" axis="0 1 0" range="0 .02"/>
            <geom type="box" size=".005 .005 .02"/></body>
          <body name="thumb" pos="0 -.02 .2"><joint name="shut" type="slide" axis="0 1 0" range="0 .02"/>
            <geom type="sphere" size=".01"/></body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="swing"/></actuator>
</mujoco>
"""
