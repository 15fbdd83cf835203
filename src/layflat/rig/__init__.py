"""A joint on a bench: the real-time loop, its drivers, its safety and its recorder.

Nothing here knows how a machine is simulated. A simulated machine is handed in (see `physics.driven.MachinePlant`).
"""
