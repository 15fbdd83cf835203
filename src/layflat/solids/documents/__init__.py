"""Documents of a machine that need no solids: air, wires, settings of the firmware, and the sheet of a first start."""
