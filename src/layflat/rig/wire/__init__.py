"""What goes over the wires: the same words for every transport, and the frames that carry them on a serial line."""
