"""Tables of the normal distribution for the noise of sensors: those of NumPy's generator, as C."""

from collections.abc import Iterator


def ziggurat_tables() -> Iterator[str]:
    """Yield the definitions of the ziggurat of NumPy's normal samples, whose noise an FMU has."""
    from numba.np.random import _constants as tables  # noqa: PLC0415  # only where something is exported

    for name, values in (("ziggurat_width", tables.wi_double), ("ziggurat_height", tables.fi_double)):
        yield f"static const double {name}[256] = {{{', '.join(float(value).hex() for value in values)}}};"
    inside = ", ".join(f"{int(value)}u" for value in tables.ki_double)
    yield f"static const uint64_t ziggurat_inside[256] = {{{inside}}};"
    yield f"static const double ziggurat_end = {float(tables.ziggurat_nor_r).hex()};"
    yield f"static const double ziggurat_inverse = {float(tables.ziggurat_nor_inv_r).hex()};"
