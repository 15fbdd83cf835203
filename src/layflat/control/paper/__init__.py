"""The control law of the paper."""

from layflat.control.kind import ControlKind
from layflat.control.paper.description import PaperControllerPart, PaperGainsPart, settings
from layflat.control.paper.gains import SIGNALS, Report, Settings
from layflat.control.paper.law import centre_shift, step, wake

__all__ = ["KIND", "PaperGainsPart"]

KIND = ControlKind(
    name="paper",
    description=PaperControllerPart,
    gains=PaperGainsPart,
    parameters=settings,
    models_plant=True,
    parameter_types=(Settings,),
    wake=wake,
    step=step,
    report=Report,
    signals=SIGNALS,
    centre_shift=centre_shift,
)
