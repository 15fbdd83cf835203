"""Tables of frames: a group of rows an episode, in Parquet files of limited size."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.lerobot.layout import BYTES_PER_MIB, DATA_PATH, INDEX_COLUMNS, MAX_DATA_FILE, FileNumber, VectorFeature


class FrameTable:
    """Table of frames; `close` ends its last file.

    Args:
        folder: of the data set.
        vectors: features of numbers by name.
    """

    def __init__(self, folder: Path, vectors: Mapping[str, VectorFeature]) -> None:
        """Store the features; a file begins with its first episode."""
        import pyarrow as pa  # noqa: PLC0415

        self._folder = folder
        self._file: Any = None
        self.number = FileNumber()  # of the present file
        # A feature of a single number is no list.
        lengths = {name: len(vector.names) for name, vector in vectors.items()}
        columns = [(name, pa.list_(pa.float32(), n) if n > 1 else pa.float32()) for name, n in lengths.items()]
        columns += [(name, pa.from_numpy_dtype(kind)) for name, kind in INDEX_COLUMNS.items()]
        self._schema: Any = pa.schema(columns)

    def add(self, columns: Mapping[str, NDArray[np.generic]]) -> None:
        """Write the columns of an episode, in a new file where the present one is large enough."""
        import pyarrow as pa  # noqa: PLC0415
        from pyarrow import parquet  # noqa: PLC0415

        arrays = []
        for field in self._schema:
            numbers = pa.array(columns[field.name].ravel())
            listed = pa.types.is_fixed_size_list(field.type)
            arrays.append(pa.FixedSizeListArray.from_arrays(numbers, type=field.type) if listed else numbers)
        if self._file is not None and self._path.stat().st_size > MAX_DATA_FILE * BYTES_PER_MIB:
            self.close()
            self.number = self.number.following()
        if self._file is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = parquet.ParquetWriter(self._path, self._schema)
        table = pa.Table.from_arrays(arrays, schema=self._schema)
        self._file.write_table(table, row_group_size=table.num_rows)

    def close(self) -> None:
        """Finish the present file, if there is one."""
        if self._file is not None:
            self._file.close()
        self._file = None

    @property
    def _path(self) -> Path:
        """Path of the present file."""
        return self._folder / DATA_PATH.format(**self.number._asdict())
