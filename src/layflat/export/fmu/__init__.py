"""FMUs for co-simulation by FMI 2.0 and 3.0, of a machine's plant, of its control law, and of both.

The way of a value: a model (`model.py`) places it among the numbers of an instance, by which the description
(`description.py`) and the C sources (`source/`) know it; the laws' functions (`plant.py`, and those of the control law)
are linked with these sources for each system (`libraries.py`), and packed (`archive.py`).
"""

__all__: list[str] = []
