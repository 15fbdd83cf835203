"""Physical scene of the cell in MuJoCo: parts, dynamics, cameras, and the truth for evaluation."""

from layflat.cell.scene.scene import Scene
from layflat.cell.scene.truth import FruitTruth, SceneTruth

__all__ = ["FruitTruth", "Scene", "SceneTruth"]
