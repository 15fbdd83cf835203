"""Virtual device at the other end of the wires: a simulated machine behind the interface of a real one."""
