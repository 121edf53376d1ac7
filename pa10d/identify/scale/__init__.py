"""A known weight sets the scale of every torque.

What a sensor or a motor current calls one newton metre may be anything near it, and no fit to the
arm alone can tell: all masses would come out with the same error. A body that is known breaks that.
"""

from pa10d.identify.scale.body import Body
from pa10d.identify.scale.gains import JointGain, Load, TorqueGains, torque_gains
from pa10d.identify.scale.prediction import Prospect, predicted_errors, prospects

__all__ = [
    "Body",
    "JointGain",
    "Load",
    "Prospect",
    "TorqueGains",
    "predicted_errors",
    "prospects",
    "torque_gains",
]
