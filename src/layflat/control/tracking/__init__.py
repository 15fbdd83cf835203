"""The tracking law: follows moving and resting demands with a model of the whole plant in the loop."""

from layflat.control.kind import ControlKind
from layflat.control.tracking.description import TrackingControllerPart, settings
from layflat.control.tracking.law import SIGNALS, Report, Settings, step, wake

KIND = ControlKind(
    name="tracking",
    description=TrackingControllerPart,
    parameters=settings,
    models_plant=True,
    parameter_types=(Settings,),
    wake=wake,
    step=step,
    report=Report,
    signals=SIGNALS,
    plans=True,
    gives_up="given_up",
)
