"""How air, hose, valve, brake and arm move: scalar laws, compiled."""
