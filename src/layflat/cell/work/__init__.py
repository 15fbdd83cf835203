"""A cell at work: hardware, what decides, who observes, and what came of it."""
