"""Arrays and data sets as annotations name them."""

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray  # takes long to import

Array = NDArray[np.float64]  # of floats, of any shape
Dataset: TypeAlias = "xarray.Dataset"  # signals by name, over time: a run or a log
Picture = NDArray[np.uint8]  # of a camera, 0 to 255: (H, W, 3) RGB, or (H, W) grey
