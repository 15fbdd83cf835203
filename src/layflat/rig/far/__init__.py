"""The far side of the wires, for those who have no rig: a machine in motion behind the interface of a real one."""
