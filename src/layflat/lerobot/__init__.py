"""Data sets in LeRobot's layout, version 3.0, written without LeRobot."""

from layflat.lerobot.layout import CameraFeature, VectorFeature
from layflat.lerobot.writer import EpisodeWriter, WrittenDataset

__all__ = ["CameraFeature", "EpisodeWriter", "VectorFeature", "WrittenDataset"]
