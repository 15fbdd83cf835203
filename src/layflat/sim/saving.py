"""Machines and runs as files."""

from pathlib import Path

from layflat.arrays import Dataset
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.machine.saving import save_machine


def save(item: "Machine | Dataset", path: str | Path) -> Path:
    """Write a machine as a description file, or a run or metrics as NetCDF, and return the path.

    `load` reads the machine again, with every value as it was, `open_run` the run. A file that is there is replaced.

    Args:
        item: a machine, a run, or metrics.
        path: path of the file; ".toml" is usual for a machine, ".nc" for a run.

    Raises:
        InputError: `item` is none of these.
        OutputError: the file can't be written.

    Example:
        >>> import layflat as lf
        >>> heavier = lf.changed(lf.load("paper-arm"), "arm.payload", "2 kg")
        >>> path = lf.save(heavier, "heavier.toml")
        >>> lf.load(path) == heavier
        True
    """
    if isinstance(item, Machine):
        return save_machine(item, Path(path))
    if not hasattr(item, "data_vars"):
        raise InputError(f"{shown(item)} can't be saved", where="item", right="give a machine, a run or metrics")
    from layflat.sim.dataset import save_run  # noqa: PLC0415  # xarray takes long to import

    return save_run(item, Path(path))
