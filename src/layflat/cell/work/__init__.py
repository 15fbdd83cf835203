"""A cell at work: station, packers, observers and results."""
