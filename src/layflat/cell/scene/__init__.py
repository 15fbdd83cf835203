"""The cell's physical scene in MuJoCo: what stands in it, how it moves, and what evaluation may know of it."""

from layflat.cell.scene.scene import Scene
from layflat.cell.scene.truth import FruitTruth, Truth

__all__ = ["FruitTruth", "Scene", "Truth"]
