"""A cell at work: hardware and eyes, what decides, what looks on, and what came of it."""
