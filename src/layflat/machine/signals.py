"""Signals of a machine in motion: names, units and meanings, simulated and recorded alike.

Input signals are in motion/scenario.py; reports of a control law are named by the law (see control/kind.py).
"""

SIGNALS: dict[str, tuple[str, str]] = {
    "angle": ("rad", "joint angle"),
    "velocity": ("rad/s", "joint velocity"),
    "pressure_a": ("Pa", "absolute pressure in hose A"),
    "pressure_b": ("Pa", "absolute pressure in hose B"),
    "temperature_a": ("K", "temperature of the air in hose A"),
    "temperature_b": ("K", "temperature of the air in hose B"),
    "valve_opening": ("1", "opening of the valve towards filling hose A, fraction of full opening"),
    "voltage": ("V", "control voltage"),
    "measured_angle": ("rad", "angle as sampled"),
    "measured_pressure": ("Pa", "differential pressure as sampled"),
    "hose_torque": ("N m", "torque lost in hose and strap"),
    "gas_work": ("J", "work of the air on the joint since the start"),
    "load_work": ("J", "work of external torques and gravity since the start"),
    "hose_work": ("J", "work done on hose and strap losses since the start"),
    "hose_stored": ("J", "part of it that is stored"),
    "brake_heat": ("J", "heat of the brake since the start"),
    "damping_heat": ("J", "heat of viscous friction and stops since the start"),
    "air_taken": ("kg", "air taken from the supply since the start"),
    "tip": ("m", "position of the tip"),
}
"""Unit and meaning of each signal."""


def signal_attributes(name: str) -> dict[str, str]:
    """Return the attributes of a signal's variable in a data set."""
    unit, meaning = SIGNALS[name]
    return {"units": unit, "long_name": meaning}
