"""Arms in space: serial chains of joints and links."""

from layflat.physics.arms.chain.description import ChainPart
from layflat.physics.arms.chain.laws import Chain, dynamics, points, turning
from layflat.physics.arms.chain.parameters import bodies, parameters
from layflat.physics.arms.kind import ArmKind, ArmLaws

KIND = ArmKind(
    name="chain",
    description=ChainPart,
    parameters=parameters,
    bodies=bodies,
    parameter_types=(Chain,),
    laws={Chain: ArmLaws(joints=None, dynamics=dynamics, points=points, axes=3, turning=turning)},
)
