"""The arm of a design in three dimensions: by the solids of its joints, or by rods."""

from contextlib import suppress

from layflat.errors import InputError
from layflat.pages.look.arm_scene import ArmScene
from layflat.pages.studio.session import StudioSession
from layflat.pages.studio.views import ResultPanel

ARM_LABEL = "The arm in three dimensions, in mid-stroke"


class ArmView(ResultPanel):
    """Arm in mid-stroke, as it is built; arms of kinds without bodies have no view."""

    def __init__(self, session: StudioSession) -> None:
        """Make the panel within the current element, with an arm of rods."""
        super().__init__("Arm")
        self._session, self._drawn = session, session.design.machine
        self._scene: ArmScene | None = None
        with self.content, suppress(InputError):
            self._scene = ArmScene(self._drawn, label=ARM_LABEL)
        self.head.set_visibility(self._scene is not None)

    def show(self) -> None:
        """Draw the arm of the session's solids, by rods where there are none."""
        made = self._session.solids
        if made is None or self._scene is None:
            return
        machine, solids = made
        if machine != self._drawn:
            self._drawn = machine
            with suppress(InputError):  # a mesh is not there: the arm before stays, and other checks report it
                self._scene.show_machine(machine)
        self._scene.show_solids(solids)
