"""The device at the other end of the wires, where there is no real one: a simulated machine behind its interface."""
