"""Laws of the plant (air, hose, valve, brake, arm): scalar functions that are compiled."""
