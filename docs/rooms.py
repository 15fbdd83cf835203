"""Draw the rooms of the package and the imports between them into docs/rooms.png."""

import tomllib
from itertools import chain
from pathlib import Path

import grimp
import matplotlib.pyplot as plt
from matplotlib.patches import FancyArrowPatch

ROOT = Path(__file__).parents[1]
EVERYWHERE = {
    "description",
    "errors",
    "arrays",
    "files",
    "extras",
    "outputs",
    "memory",
    "_version",
}  # used by most rooms
SHOWN = 3  # modules of a room that import one of another, from which on an arrow is drawn
GREYS = ("white", "0.92")  # of layers, by turns


def rooms_by_layer() -> list[list[str]]:
    """Return the rooms of each layer, from the top."""
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]
    return [[room.strip() for room in layer.split("|")] for layer in contract["layers"]]


def lines_of(room: str) -> int:
    """Return how many lines of code a room has."""
    place = ROOT / "src" / "layflat" / room
    files = place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")]
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


def imports_between(rooms: list[str]) -> dict[tuple[str, str], int]:
    """Return how many modules of one room import any of another, by (importing room, imported room)."""
    graph, found = grimp.build_graph("layflat"), dict[tuple[str, str], int]()
    for module in graph.modules - {"layflat"}:
        own = module.split(".")[1]
        others = {name.split(".")[1] for name in graph.find_modules_directly_imported_by(module) if "." in name}
        for other in others - {own}:
            found[own, other] = found.get((own, other), 0) + 1
    return {pair: count for pair, count in found.items() if set(pair) <= set(rooms)}


def main() -> None:
    """Draw the rooms, and the imports between them, into docs/rooms.png."""
    layers = rooms_by_layer()
    figure, axes = plt.subplots(figsize=(11.0, 9.0))
    place: dict[str, tuple[float, float]] = {}
    for depth, layer in enumerate(layers):
        axes.axhspan(-depth - 0.5, -depth + 0.5, color=GREYS[depth % 2], zorder=0)
        for i, room in enumerate(layer):
            place[room] = ((i + 0.5 + 0.18 * (depth % 3 - 1)) / len(layer), -float(depth))
    for (own, other), count in imports_between(list(place)).items():
        if count >= SHOWN and other not in EVERYWHERE:
            ends = FancyArrowPatch(
                place[own], place[other], arrowstyle="-|>", mutation_scale=9, shrinkA=14, shrinkB=14, color="0.45",
                linewidth=0.4 * count**0.5, connectionstyle="arc3,rad=0.12", alpha=0.7, zorder=1,
            )  # fmt: skip
            axes.add_patch(ends)
    box = {"boxstyle": "round,pad=0.35", "facecolor": "white", "edgecolor": "black"}
    for room, (x, y) in place.items():
        axes.text(x, y, f"{room}\n{lines_of(room)} lines", ha="center", va="center", fontsize=8, bbox=box, zorder=2)
    axes.set(xlim=(-0.02, 1.02), ylim=(-len(layers) + 0.4, 0.6))
    axes.set_axis_off()
    shown = f"Arrows: imports by {SHOWN} modules or more, but for what is used everywhere (description and below)."
    title = f"Rooms of layflat by layer, {sum(map(lines_of, chain(*layers)))} lines. {shown}"
    axes.set_title(title, fontsize=9, y=-0.03)
    figure.savefig(ROOT / "docs" / "rooms.png", dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main()
