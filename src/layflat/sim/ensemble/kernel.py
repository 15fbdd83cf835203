"""The compiled run of many machines: the time loop with a run per SIMD lane, and metrics accumulated on the way.

In these laws `group` is a `LaneGroup`, `zero` a zero in every lane, k a control cycle, i a part of it, j a joint.
"""

from typing import Any, NamedTuple

from layflat.jit import composition, law, portable_kernel
from layflat.lanes import each, gather, in_lanes, read_lanes, select, slots, width
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.joint import AirLedger, JointState
from layflat.physics.plant import states_at_rest
from layflat.sim.ensemble.results import MoveArrays, Results, Runs, ScenarioArrays
from layflat.sim.ensemble.watch import (
    NO_JOINT_MOVE,
    NO_PROGRESS,
    Watch,
    begin_moves,
    record_divergence,
    record_metrics,
    record_trace,
    slice_watch,
    write_totals,
)
from layflat.sim.loop import (
    NO_INJECTION,
    ZERO_JOINT_SIGNALS,
    ZERO_NOISE,
    ZERO_SHARED_SIGNALS,
    CycleSpan,
    JointSignals,
    LoopPorts,
    MachineState,
    SharedSignals,
    initial_memory,
    is_number,
    run_span,
    surroundings,
)

JOINT_ITEMS: tuple[float, ...] = tuple(ZERO_JOINT_SIGNALS)  # plain tuples, since `each` takes items of these alone
SHARED_ITEMS: tuple[float, ...] = tuple(ZERO_SHARED_SIGNALS)


class LaneGroup(NamedTuple):
    """Runs simulated in parallel lanes, from number `first` on, with the arrays of their results."""

    first: int
    runs: Runs
    scenarios: ScenarioArrays
    moves: MoveArrays
    results: Results
    watch: Watch
    progress: Any  # `ArmProgress` in a slot
    joint_moves: Any  # slots of `JointMove`


@composition
def _has_changes(group, k, zero):
    """Return whether any lane's signals change in control cycle k.

    They seldom do, and gathering them costs more than the control law.
    """
    count = 0
    for lane in range(width(zero)):
        count += group.scenarios.changes[group.runs.scenario[group.first + lane], k]
    return count > 0


@law
def _vary_signal(signal, factor, added):
    return signal * factor + added


@composition
def _joint_signals(group, k, j, zero):
    """Return the signals on joint j in control cycle k, with a lane a run, varied by each run's factors and terms.

    They are gathered number by number: views of arrays would cost more than all the rest.
    """
    runs, first, scratch = group.runs, group.first, group.watch.scratch
    for lane in range(width(zero)):
        for i in range(group.scenarios.by_joint.shape[3]):
            scratch[i, lane] = group.scenarios.by_joint[runs.scenario[first + lane], k, j, i]
    signals = read_lanes(JOINT_ITEMS, scratch, zero)
    factors = read_lanes(JOINT_ITEMS, runs.factors[j, :, first:], zero)
    return JointSignals(*each(_vary_signal, signals, factors, read_lanes(JOINT_ITEMS, runs.added[j, :, first:], zero)))


@law
def _signal_or_default(signal, default):
    return select(is_number(signal), signal, default)


@composition
def _surroundings(group, air, k):
    """Return the surroundings in control cycle k, with a lane a run; a signal that is absent has the run's default."""
    runs, first, scratch, zero = group.runs, group.first, group.watch.scratch, 0.0 * air.ambient_pressure
    for lane in range(width(zero)):
        for i in range(group.scenarios.shared.shape[2]):
            scratch[i, lane] = group.scenarios.shared[runs.scenario[first + lane], k, i]
    signals, defaults = read_lanes(SHARED_ITEMS, scratch, zero), read_lanes(SHARED_ITEMS, runs.shared[:, first:], zero)
    return surroundings(air, SharedSignals(*each(_signal_or_default, signals, defaults)))


@composition
def _update_metrics(group, arm, states, k, cycle):
    """Update the metrics with the states at the start of cycle k (of `cycle` s); return whether the run ends there.

    It is the port `observe` of `LoopPorts`.
    """
    watch, results, moves, scenarios = group.watch, group.results, group.moves, group.runs.scenario
    progress, joint_moves = group.progress, group.joint_moves
    record_metrics(watch, results, moves, scenarios, arm, states, progress, joint_moves, group.first, k, cycle)
    return k == group.scenarios.by_joint.shape[1]


@composition
def _load_inputs(group, air, around, acting, noise, k):
    """Load the noise of control cycle k, and signals and surroundings where they change, into their slots.

    It is the port `load` of `LoopPorts`.
    """
    zero, samples = 0.0 * air.ambient_pressure, group.runs.noise
    if _has_changes(group, k, zero):
        around[0] = _surroundings(group, air, k)
        for j in range(group.scenarios.by_joint.shape[2]):
            acting[j] = _joint_signals(group, k, j, zero)
    for j in range(group.scenarios.by_joint.shape[2]):
        noise[j] = read_lanes(ZERO_NOISE, samples[k % len(samples), j, :, group.first :], zero)


@composition
def _record(group, joints, states, around, sensed, voltages, report, k, i):  # noqa: ARG001  (a port)
    """Write the traces of all joints in control cycle k, every `results.every` cycles: the port `record`."""
    for j in range(group.scenarios.by_joint.shape[2]):
        record_trace(group.watch, group.results, joints[j], states[j], voltages[j], group.first, j, k)


@composition
def _check(group, states, k, i):  # noqa: ARG001
    """Store cycle k in lanes that diverge for the first time; return False, so that the others go on.

    It is the port `check` of `LoopPorts`.
    """
    for j in range(group.scenarios.by_joint.shape[2]):
        record_divergence(states[j], group.progress, k)
    return False


@law
def _with_air_alone(state):
    return JointState(state.motion, state.valve, state.hose_a, state.hose_b, AirLedger(0.0))


@composition
def initial_states(arm, like, runs, first, around):
    """Return the initial states of the joints, in lanes: at rest at each run's angles (rad) and pressures (Pa).

    Of `runs` only `angles` and `pressures` are read.
    """
    zero = 0.0 * around.ambient_pressure
    angles, firsts, seconds = slots(like, zero), slots(like, zero), slots(like, zero)
    for j in range(len(like)):
        angles[j] = read_lanes(0.0, runs.angles[j : j + 1, first:], zero)
        firsts[j], seconds[j] = read_lanes((0.0, 0.0), runs.pressures[j, :, first:], zero)
    states = states_at_rest(arm, like, gather(like, angles), gather(like, firsts), gather(like, seconds), around)
    return in_lanes(each(_with_air_alone, states), zero)


@composition
def run_lanes(case, first, runs, scenarios, moves, timing, results, watch):
    """Simulate as many runs as there are lanes, from number `first` on, through their scenarios from rest.

    Args: any `Case`, or its `Like`, for the order of the runs' parameters; number of the first run; `Runs`;
    `ScenarioArrays`; `MoveArrays`; `Timing`; `Results`, which are filled; a new `Watch` over these runs.
    """
    case = read_lanes(case, runs.parameters[:, first:])
    like, zero = case.joints, 0.0 * case.air.ambient_pressure
    progress, joint_moves = slots((in_lanes(NO_PROGRESS, zero),)), slots(like, in_lanes(NO_JOINT_MOVE, zero))
    group = LaneGroup(first, runs, scenarios, moves, results, watch, progress, joint_moves)
    begin_moves(watch, moves, runs.scenario, case.arm, progress, joint_moves, first)
    injections = slots(like, in_lanes(NO_INJECTION, zero))
    for j in range(len(like)):
        injections[j] = read_lanes(NO_INJECTION, runs.injections[j, :, first:], zero)
    instants = CycleSpan(0, scenarios.by_joint.shape[1] + 1)
    around = _surroundings(group, case.air, instants.first)
    rest = initial_states(case.arm, like, runs, first, around)
    joints, states = slots(like), slots(rest)
    machine = MachineState(
        case.arm,
        case.settings,
        case.air,
        slots((around,)),
        slots(like, in_lanes(ZERO_JOINT_SIGNALS, zero)),
        joints,
        states,
        slots(like, in_lanes(ZERO_COMMANDS, zero)),
        slots(like, in_lanes(FULL_FRACTIONS, zero)),
        injections,
        slots((initial_memory(case.settings, joints, states),)),
    )
    run_span(machine, instants, timing, LoopPorts(_update_metrics, _load_inputs, _record, _check), group)
    write_totals(watch, results, states, progress, first, len(like))


@portable_kernel(in_lanes=True)
def run_block(case, runs, scenarios, moves, timing, results, watch):
    """Simulate all runs of a block, as many at a time as there are lanes; the watch is as wide as the block.

    Args: as of `run_lanes`, without the number of the first run.
    """
    lanes = width(case, runs.parameters)
    for first in range(0, len(runs.scenario), lanes):
        run_lanes(case, first, runs, scenarios, moves, timing, results, slice_watch(watch, first, lanes))
