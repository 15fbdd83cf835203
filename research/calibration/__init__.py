"""What the paper leaves open is found from what it reports: `python -m research.calibration`."""
