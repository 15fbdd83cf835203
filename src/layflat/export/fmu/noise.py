"""Table of the normal distribution for the noise of sensors: that of NumPy's generator, as C."""

from collections.abc import Iterator

from layflat.sim.ensemble.seeds import ziggurat_tables


def table_definitions() -> Iterator[str]:
    """Yield the definitions of the ziggurat of NumPy's normal samples, from which noise.c computes its other tables."""
    tables = ziggurat_tables()
    widths = ", ".join(float(value).hex() for value in tables.widths)
    yield f"static const double ziggurat_width[256] = {{{widths}}};"
    yield f"static const double ziggurat_end = {tables.tail.hex()};"
    yield f"static const double ziggurat_inverse = {tables.tail_scale.hex()};"
