"""Safety of a rig, independent of its controller: faults, their detection, and the reactions to them."""
