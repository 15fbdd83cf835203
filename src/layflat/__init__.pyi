from layflat._version import __version__ as __version__
from layflat.design import design_joint as design_joint
from layflat.design import size_joint as size_joint
from layflat.machine import Machine as Machine
from layflat.machine import changed as changed
from layflat.machine import load as load
from layflat.machine import names as names
from layflat.sim import Scenario as Scenario
from layflat.sim import rollout as rollout
from layflat.sim.ensemble import ensemble as ensemble

__all__: list[str]
