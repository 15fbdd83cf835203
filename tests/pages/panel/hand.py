"""A person who presses every button of the panel, with hard values in all fields, while the arm moves."""

import time

from tests.pages.panel.arm import OBEYS, moving
from tests.pages.pressing import Presser
from tests.pages.visitor import Visitor

STOPPED = 5  # times
STOPS, ASKS = {"Stop", "Vent"}, {"Hand over", "Keep driving", "Drive from here"}
REST = {"Off", "Stopped", "Fault"}


class Hand:
    """A person who presses everything, and another one who looks on and would like to drive."""

    def __init__(self, visitor: Visitor, other: Visitor) -> None:
        self.visitor, self.other = visitor, other
        self.presser = Presser(visitor, self._fill, self._go_on)
        self.answers: list[float] = []  # from Stop to the page that tells it, s
        self._moves = True  # whether the arm is to move on after each press

    def press_everything(self) -> None:
        """Press all buttons while the arm moves, then those that end it, at rest those that wait for that."""
        visitor, presser = self.visitor, self.presser
        visitor.enter("name", "to and fro")
        visitor.press("Save")
        visitor.until(lambda: "saved " in visitor.text)
        presser.press_all(leave=STOPS | ASKS)
        self._moves = False
        self._go_to_target()
        for _ in range(STOPPED):
            self._move_on()
            begun = time.monotonic()
            presser.press("Stop")
            visitor.until(lambda: visitor.text_of("lf-state") not in OBEYS)
            self.answers.append(time.monotonic() - begun)
        presser.press("Vent")
        visitor.until(lambda: visitor.text_of("lf-state") in REST)
        self._choose("failure", "e-stop")
        visitor.press("Fail")
        visitor.until(lambda: visitor.text_of("lf-state") == "Fault")
        visitor.press("Heal")
        self._press_at_rest()
        visitor.press("Look again")  # there are whole logs by now
        self._press_at_rest()
        presser.press_all(leave=ASKS)
        self._hand_over()

    def _go_to_target(self) -> None:
        """Press what waits for angles in the fields, which the last hard values may not be."""
        self._move_on()
        self.presser.press("Take present angles")
        self.visitor.until(lambda: self.visitor.enabled("Go to target"))
        self.presser.press("Go to target")

    def _press_at_rest(self) -> None:
        """Press all that needs a rig at rest, again where a check has taken it away for a while."""
        for box in self.visitor.each():
            if box[1].get("tag") == "q-checkbox":
                self.visitor.emit(box, "update:modelValue", True)
        for _ in range(3):
            self.presser.press_all(leave=ASKS | {"Start"})
            self.visitor.until(lambda: self.visitor.text_of("lf-state") in REST, 60.0)

    def _choose(self, name: str, option: str) -> None:
        (_, found), _ = self.visitor.find(name, "update:modelValue")
        self.visitor.enter(name, next(one for one in found["props"]["options"] if one["label"] == option))

    def _fill(self, turn: int) -> None:
        """Put hard values into the fields before two of three presses; the buttons' own values stay for the third."""
        if turn % 3 and self._moves:
            self.presser.fill(turn)

    def _go_on(self, _: str) -> None:
        if self._moves:
            self._move_on()

    def _move_on(self) -> None:
        """Let the arm move again, whatever was pressed."""
        visitor = self.visitor
        for name in ("Heal", "Reset"):
            if visitor.enabled(name):
                visitor.press(name)
        if visitor.text_of("lf-state") != "Moving":
            self._choose("saved", "to and fro")
            visitor.press("Load")
            visitor.until(lambda: moving(visitor), 60.0)

    def _hand_over(self) -> None:
        """Press who drives, on both pages."""
        visitor, other, press = self.visitor, self.other, self.presser.press
        for name in ("Keep driving", "Hand over"):
            other.press("Drive from here")
            press(name)
            visitor.until(lambda: not {"Keep driving", "Hand over"} & self.presser.buttons().keys())
        press("Drive from here")
        other.until(lambda: any("hidden" not in one.get("class", []) for _, one in other.named("Hand over")))
        other.press("Hand over")
        visitor.until(lambda: "this page drives" in visitor.text)
