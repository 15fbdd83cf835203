"""Which way, and how fast: motions that a machine's arm is asked for, from its description alone."""
