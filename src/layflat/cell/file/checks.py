"""Checks of a cell: parts that overlap, out of reach or view, unknown kinds, too small, a lift too short."""

from itertools import combinations
from math import degrees
from pathlib import Path

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.geometry import outlines_overlap
from layflat.motion.planar import PlanarReach


def check(cell: Cell) -> None:
    """Raise ValueError with one line for the first violated rule of a cell."""
    for rule in (
        _check_arm,
        _check_sources,
        _check_kinds,
        _check_markers,
        _check_sizes,
        _check_separation,
        _check_reach,
        _check_view,
        _check_lift,
    ):
        rule(cell)


def _check_arm(cell: Cell) -> None:
    """Raise ValueError unless the machine is a level arm of two joints whose home is inside their working strokes."""
    joints = list(cell.machine.joints)
    if len(joints) != 2 or cell.machine.arm.gravity != 0.0:
        raise ValueError(
            f"machine {cell.machine.name!r} is not a level arm of two joints; take one such as 'paper-arm'"
        )
    if set(cell.mount.home) != set(joints):
        raise ValueError(f"mount.home has {sorted(cell.mount.home)}; give an angle for each of {joints}")
    for name, joint in cell.machine.joints.items():
        half = joint.stops.working_stroke / 2
        if abs(angle := cell.mount.home[name]) > half:
            limits = f"-{degrees(half):.4g} to {degrees(half):.4g} deg"
            raise ValueError(f"mount.home.{name} is outside of the working stroke: {degrees(angle):.4g}, not {limits}")


def _check_sources(cell: Cell) -> None:
    """Raise ValueError unless produce comes in trays or by a conveyor with space for the largest fruit, not both."""
    if not cell.sources:
        raise ValueError("there is neither a tray nor a conveyor, by which produce comes; give one")
    if cell.tray and cell.conveyor is not None:
        raise ValueError(f"there are trays ({', '.join(cell.tray)}) and a conveyor; leave one of them out by omits")
    if (belt := cell.conveyor) is not None and belt.spacing[0] < (
        largest := max((cell.produce[kind].diameter.max for kind in belt.produce if kind in cell.produce), default=0.0)
    ):
        spacing = _mm(belt.spacing[0])
        raise ValueError(f"conveyor.spacing {spacing} is less than the largest fruit, {_mm(largest)}; give more")


def _check_kinds(cell: Cell) -> None:
    """Raise ValueError for unknown kinds or grades, a container's kind that vision doesn't know, or no network file."""
    known_kinds = sorted(cell.produce)
    for key, source in cell.sources.items():
        if unknown := [kind for kind in source.produce if kind not in cell.produce]:
            raise ValueError(f"{key}.produce names the unknown kind {unknown[0]!r}; known are {known_kinds}")
    for name, container in cell.container.items():
        key, kind = f"container.{name}", container.kind
        if kind not in cell.produce:
            raise ValueError(f"{key}.kind is the unknown kind {kind!r}; known are {known_kinds}")
        if not cell.produce[kind].recognised:
            raise ValueError(f"{key}.kind {kind!r} is not recognised by vision; set produce.{kind}.recognised")
        if container.grade not in (grades := list(cell.produce[kind].grade)):
            raise ValueError(f"{key}.grade {container.grade!r} is none of {kind}; its grades are {grades}")
    if cell.network is not None and not Path(cell.network.file).is_file():
        raise ValueError(f"network.file: there is no {cell.network.file}; give the path of an ONNX file from here")


def _check_markers(cell: Cell) -> None:
    """Raise ValueError if a marker's number occurs twice, or on the calibration board."""
    seen: dict[int, str] = {}
    board = cell.board
    held = range(board.first_id, board.first_id + board.columns * board.rows // 2)
    for name, marker in cell.base_markers.marker.items():
        where = f"base_markers.marker.{name}.number {marker.number}"
        if marker.number in seen:
            raise ValueError(f"{where} is that of {seen[marker.number]!r} too; give each marker its own number")
        if marker.number in held and board.dictionary == cell.base_markers.dictionary:
            raise ValueError(f"{where} is one of the board's ({held[0]} to {held[-1]}); give a number beyond them")
        seen[marker.number] = name


def _check_sizes(cell: Cell) -> None:
    """Raise ValueError if a container's places or a source are too small for their fruit, or the cup too wide."""
    for name, container in cell.container.items():
        kind, layout = cell.produce[container.kind], container.layout
        greatest = min(kind.grade[container.grade].max, kind.diameter.max)
        if layout.opening < greatest:
            raise ValueError(
                f"container.{name} is too small: a place of {layout.name!r} takes {_mm(layout.opening)}, "
                f"{container.kind} of grade {container.grade!r} has up to {_mm(greatest)}; give another layout"
            )
    for key, source in cell.sources.items():
        for kind_name in source.produce:
            if min(source.size) < (largest := cell.produce[kind_name].diameter.max):
                raise ValueError(f"{key} is too small for a {kind_name} of {_mm(largest)}; give a greater size")
    cup = cell.cup.diameter
    smallest = min((kind.diameter.min for kind in cell.incoming.values()), default=cup)
    if cup > smallest:
        raise ValueError(f"cup.diameter {_mm(cup)} is wider than the smallest fruit, {_mm(smallest)}; give less")


def _check_separation(cell: Cell) -> None:
    """Raise ValueError if parts overlap, or do not stand on the table."""
    low = np.array(cell.table.centre) - np.array(cell.table.size) / 2
    high = low + np.array(cell.table.size)
    for name, outline in cell.outlines.items():
        if (outline < low).any() or (outline > high).any():
            raise ValueError(f"{name} does not stand on the table; move it, or give a greater table.size")
    for (one, first), (other, second) in combinations(cell.outlines.items(), 2):
        if outlines_overlap(first, second):
            raise ValueError(f"{one} and {other} overlap; move one of them")


def _check_reach(cell: Cell) -> None:
    """Raise ValueError if places or trays are out of the arm's reach, or all of the conveyor's middle line is."""
    targets, reach = {}, PlanarReach(cell.machine)
    for name, tray in cell.tray.items():
        smallest = min(cell.produce[kind].diameter.min for kind in tray.produce)
        across = [np.linspace(-1, 1, 9) * (side - smallest) / 2 for side in tray.size]
        targets[f"tray.{name}"] = tray.to_cell_frame(np.stack(np.meshgrid(*across), axis=-1).reshape(-1, 2))
    if (belt := cell.conveyor) is not None:
        # Some point of its path is enough: the belt moves fruit into and out of the reach.
        along = np.linspace(-belt.size[0] / 2, belt.size[0] / 2, 41)
        middle = belt.to_cell_frame(np.stack([along, 0.0 * along], axis=1))
        targets["conveyor"] = min(middle, key=lambda point: reach.distance_outside(*point.tolist()))[None]
    targets |= {f"container.{name}": container.places for name, container in cell.container.items()}
    for name, points in targets.items():
        for x, y in points.tolist():
            if (missing := reach.distance_outside(x, y)) > 0.0:
                raise ValueError(
                    f"{name} is out of the arm's reach by {_mm(max(missing, 1e-3))} at x = {_mm(x)}, "
                    f"y = {_mm(y)} (working strokes of {cell.machine.name!r}); move it"
                )


def _check_view(cell: Cell) -> None:
    """Raise ValueError unless the camera, above the lift, sees all centres of sources and containers, and a marker."""
    camera, mend = cell.camera, "change camera.position or camera.looks_at"
    if camera.position[2] <= cell.lift.clearance:
        height = _mm(camera.position[2])
        raise ValueError(f"camera.position is not above the lift, {_mm(cell.lift.clearance)}; raise it from {height}")
    if camera.looks_at[2] >= camera.position[2]:
        raise ValueError(f"camera looks up, not at the table; {mend}")
    centres = {name: source.centre for name, source in cell.sources.items()}
    centres |= {f"container.{name}": container.centre for name, container in cell.container.items()}
    for name, centre in centres.items():
        if not cell.camera.sees(centre):
            raise ValueError(f"camera does not see {name}: its centre is outside of the picture; {mend}")
    if not any(cell.camera.sees(marker.centre) for marker in cell.base_markers.marker.values()):
        raise ValueError(f"camera sees none of base_markers; {mend}, or move the markers")


def _check_lift(cell: Cell) -> None:
    """Raise ValueError if the lift can't go down to the lowest fruit, or carry the tallest over all obstacles."""
    low = cell.lift.clearance - cell.lift.stroke
    for name, kind in cell.incoming.items():
        if low > (lowest := kind.diameter.min * kind.flattening.min):
            reach = f"the cup comes down to {_mm(low)}, a {name} is as low as {_mm(lowest)}"
            raise ValueError(f"lift.stroke is too short: {reach}; give a longer stroke")
    tallest, over = cell.tallest_fruit, cell.obstacle_height
    if cell.lift.clearance < tallest + over:
        pass_over = f"a fruit of {_mm(tallest)} must pass over {_mm(over)}"
        raise ValueError(f'lift.clearance is too small: {pass_over}; give more than "{_mm(tallest + over)}"')


def _mm(length: float) -> str:
    return f"{1e3 * length:.0f} mm"
