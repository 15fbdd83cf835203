"""A rig in ROS 2: topics of its state, an action that moves it, services that bring and vent its air."""

import re
import time
from collections.abc import Callable
from typing import Any

from layflat.errors import InputError
from layflat.machine import Machine
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigSession, RigSnapshot
from layflat_ros2 import messages
from layflat_ros2.execution import (
    CANCELED_OUTCOME,
    LINK_LOST_OUTCOME,
    OBEYING_STATES,
    REPLACED_OUTCOME,
    Execution,
    Outcome,
)
from layflat_ros2.rosbridge import LINK_DOWN, LINK_UP, Message, Rosbridge
from layflat_ros2.trajectory import GoalError, GoalReader

STEP_INTERVAL = 0.005  # between two steps, s: demands are extrapolated for ten times as long
FEEDBACK_INTERVAL = 0.05  # between two feedbacks on a goal, s
DIAGNOSTICS_INTERVAL = 1.0  # between two diagnostics where nothing changes, s
DIAGNOSTICS_TOPIC = "/diagnostics"
SERVICE_NAMES = ("start", "hold", "stop", "reset")  # requests of a session
NAMESPACE_PATTERN = re.compile(r"(/[A-Za-z_]\w*)+", re.ASCII)


class RigNode:
    """Node of a rig: `RigNode(machine, session, rosbridge).run(stopped)`.

    Args:
        machine: description of the rig.
        session: session on it.
        rosbridge: connection to rosbridge.
        namespace: beginning of all names, /NAME.
        rate: joint states a second.
        hardware: address of the rig, for diagnostics.
        report: function that shows a line to people.

    Raises:
        InputError: an argument is wrong.
    """

    def __init__(
        self,
        machine: Machine,
        session: RigSession,
        rosbridge: Rosbridge,
        *,
        namespace: str = "/layflat",
        rate: float = 50.0,
        hardware: str = "",
        report: Callable[[str], None] = lambda _: None,
    ) -> None:
        check_options(namespace, rate)
        self._machine, self._session, self._rosbridge, self._hardware = machine, session, rosbridge, hardware
        self._joints, self._reader, self._report = list(machine.joints), GoalReader(machine), report
        self._states, self._pressures, self._commands, self._action = (
            f"{namespace}/{name}" for name in ("joint_states", "pressures", "joint_commands", "follow_joint_trajectory")
        )
        self._services = {f"{namespace}/{name}": name for name in SERVICE_NAMES}
        self._interval = 1.0 / rate
        self._next_state = self._next_feedback = self._next_diagnostics = 0.0
        self._reported: tuple[RigState, Fault] | None = None  # by the last diagnostics
        self._cycle_time, self._cycle_since = -1.0, 0.0  # time of the last cycle (s), and instant of its arrival
        self._is_published = False  # whether the last cycle is
        self._execution: Execution | None = None
        self._is_complaining = False  # whether the last joint command was refused
        self._handlers = {
            "send_action_goal": self._take_goal, "cancel_action_goal": self._cancel, "call_service": self._serve,
            "publish": self._take_command, "status": self._show_status, LINK_DOWN: self._lose, LINK_UP: self._regain,
        }  # fmt: skip
        self._declare()

    def run(self, stopped: Callable[[], bool]) -> None:
        """Serve until `stopped()` is true; raise RigLoopError where the rig's loop ends before."""
        while not stopped():
            self.step(time.monotonic())
            time.sleep(STEP_INTERVAL)

    def step(self, now: float) -> None:
        """Handle what has come, advance the goal, publish what is due; `now` is a time of `time.monotonic()`, s.

        Raises:
            RigLoopError: the rig's loop has ended.
        """
        self._session.check()
        while (message := self._rosbridge.receive()) is not None:
            if (handler := self._handlers.get(message["op"])) is not None:
                handler(message)
        shot = self._session.snapshot()
        if shot is None:
            return
        if self._execution is not None:
            outcome = self._execution.step(self._session, shot, self._joints, now)
            if outcome is not None:
                self._finish(outcome)
            elif now >= self._next_feedback:
                self._next_feedback = now + FEEDBACK_INTERVAL
                values = self._execution.feedback(shot, self._joints, now)
                self._rosbridge.send_feedback(self._action, self._execution.identifier, values)
        self._publish(shot, now)

    def _declare(self) -> None:
        """Advertise and subscribe all names."""
        bridge = self._rosbridge
        bridge.advertise(self._states, messages.JOINT_STATE_TYPE)
        bridge.advertise(self._pressures, messages.PRESSURES_TYPE)
        bridge.advertise(DIAGNOSTICS_TOPIC, messages.DIAGNOSTICS_TYPE)
        bridge.subscribe(self._commands, messages.JOINT_STATE_TYPE)
        bridge.advertise_action(self._action, messages.TRAJECTORY_TYPE)
        for service in self._services:
            bridge.advertise_service(service, messages.TRIGGER_TYPE)

    def _publish(self, shot: RigSnapshot, now: float) -> None:
        """Publish new cycles at the rate, and diagnostics every second and where state or fault change."""
        if float(shot["time"]) != self._cycle_time:
            self._cycle_time, self._cycle_since, self._is_published = float(shot["time"]), now, False
        if now >= self._next_state and not self._is_published:
            self._next_state, self._is_published = max(self._next_state + self._interval, now), True
            self._rosbridge.publish(self._states, messages.joint_state(self._joints, shot))
            self._rosbridge.publish(self._pressures, messages.pressures(self._joints, shot))
        present = shot.state, shot.fault
        if present != self._reported or now >= self._next_diagnostics:
            self._reported, self._next_diagnostics = present, now + DIAGNOSTICS_INTERVAL
            text = messages.diagnostics(self._machine.name, self._joints, shot, self._hardware, now - self._cycle_since)
            self._rosbridge.publish(DIAGNOSTICS_TOPIC, text)

    def _take_goal(self, message: Message) -> None:
        """Begin a goal in place of the present one, or refuse it."""
        identifier, shot = str(message.get("id", "")), self._session.snapshot()
        try:
            if shot is None or shot.state not in OBEYING_STATES:
                state = "unknown" if shot is None else shot.state.name.lower()
                raise GoalError(f"the rig's state is {state}; call the service start, and wait until it is ready")
            goal = self._reader.read(message.get("args") or {}, shot["demand"].tolist(), time.time())
        except GoalError as error:
            self._report(f"goal refused: {error}")
            self._send_result(identifier, Outcome.of_error(error))
            return
        if self._execution is not None:
            self._finish(REPLACED_OUTCOME)
        self._execution = Execution(identifier, goal, time.monotonic())

    def _cancel(self, message: Message) -> None:
        if self._execution is not None and message.get("id") == self._execution.identifier:
            self._finish(CANCELED_OUTCOME)

    def _finish(self, outcome: Outcome) -> None:
        """End the present goal."""
        if self._execution is not None:
            identifier, self._execution = self._execution.identifier, None
            self._send_result(identifier, outcome)
            if outcome.text:
                self._report(f"goal: {outcome.text}")

    def _send_result(self, identifier: str, outcome: Outcome) -> None:
        self._rosbridge.send_result(self._action, identifier, outcome.status, outcome.values())

    def _serve(self, message: Message) -> None:
        """Request a start, hold, stop or reset of the session, unless its state forbids it."""
        request, shot = self._services.get(str(message.get("service"))), self._session.snapshot()
        if request is None:
            return
        refused = request == "start" and shot is not None and shot.state is RigState.FAULT
        if refused and shot is not None:
            text = f"{shot.fault_text}; call the service reset once it is over"
        else:
            getattr(self._session, request)()
            text = f"{request} requested; {DIAGNOSTICS_TOPIC} has the state"
        self._rosbridge.respond(message, {"success": not refused, "message": text})

    def _take_command(self, message: Message) -> None:
        """Demand the angles of a joint command; those without air, or while a goal is followed, are ignored."""
        shot = self._session.snapshot()
        if message.get("topic") != self._commands or self._execution is not None:
            return
        if shot is None or shot.state not in OBEYING_STATES:
            return
        try:
            self._session.ask(*_read_command(message.get("msg"), self._joints))
            self._is_complaining = False
        except InputError as error:
            if not self._is_complaining:
                self._report(f"{self._commands}: {error}")
            self._is_complaining = True

    def _show_status(self, message: Message) -> None:
        """Show a warning or an error of the server."""
        if message.get("level") in {"warning", "error"}:
            self._report(f"rosbridge: {message.get('msg')}")

    def _lose(self, _: Message) -> None:
        self._report(f"link to {self._rosbridge.address} lost; the joints come to rest")
        self._finish(LINK_LOST_OUTCOME)

    def _regain(self, _: Message) -> None:
        self._report(f"link to {self._rosbridge.address} is back")


def check_options(namespace: str, rate: float) -> None:
    """Check the options of a node; raise InputError where the namespace is no name of ROS, or the rate no frequency."""
    if not NAMESPACE_PATTERN.fullmatch(namespace):
        right = "give one such as /layflat, of letters, digits and _"
        raise InputError(f"{namespace!r} is no namespace of ROS", where="namespace", right=right)
    if not 0.1 <= rate <= 200.0:
        raise InputError(f"{rate:g} Hz", where="rate", right="give 0.1 to 200")


def _read_command(command: Any, joints: list[str]) -> tuple[list[Any], list[Any] | None]:
    """Return the angles of a joint command (rad), and its velocities (rad/s) where it has all, in order of the joints.

    Raises:
        InputError: it does not have one position for each joint.
    """
    names, angles, rates = ([], [], []) if not isinstance(command, dict) else (
        command.get(key) or [] for key in ("name", "position", "velocity")
    )  # fmt: skip
    if sorted(map(str, names)) != sorted(joints) or len(angles) != len(joints):
        right = f"give a position of each of {', '.join(joints)}"
        raise InputError(f"{len(angles)} positions of {', '.join(map(str, names))}", where="joint command", right=right)
    order = [names.index(name) for name in joints]
    has_rates = len(rates) == len(joints) and None not in rates
    return [angles[column] for column in order], [rates[column] for column in order] if has_rates else None
