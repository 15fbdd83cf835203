"""Tables of the normal distribution for the noise of sensors: those of NumPy's generator, as C."""

from collections.abc import Iterator

from layflat.sim.ensemble.seeds import ziggurat_tables


def table_definitions() -> Iterator[str]:
    """Yield the definitions of the ziggurat of NumPy's normal samples, whose noise an FMU has."""
    tables = ziggurat_tables()
    for name, values in (("ziggurat_width", tables.widths), ("ziggurat_height", tables.edges)):
        yield f"static const double {name}[256] = {{{', '.join(float(value).hex() for value in values)}}};"
    inside = ", ".join(f"{int(value)}u" for value in tables.inside)
    yield f"static const uint64_t ziggurat_inside[256] = {{{inside}}};"
    yield f"static const double ziggurat_end = {tables.tail.hex()};"
    yield f"static const double ziggurat_inverse = {tables.tail_scale.hex()};"
