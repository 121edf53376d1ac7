"""Step 2 of the paper's 3.1: from which speed on is the friction of each joint linear?"""

from __future__ import annotations

import numpy as np

from pa10d.case_study.laboratory import Laboratory
from pa10d.case_study.scope import Scope
from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed
from pa10d.paper.results import Boundaries
from pa10d.paper.told import ToldBoundary

RUN = "boundary"


def find_boundaries(lab: Laboratory, joints: int, scope: Scope) -> Boundaries:
    """One experiment with all joints in turn; the limit is on the safe side of the interval."""
    result = lab.run("boundary_velocity", scope.boundary, RUN)
    told = result["analysis"][RUN]["boundary_velocity"]
    found = {one.joint: one for one in (parsed(ToldBoundary, document) for document in told)}
    if missing := [j for j in range(1, joints + 1) if j not in found]:
        raise UserError(
            f"no boundary velocity for joint {missing[0]}: {' '.join(result['recommendation'])}"
        )
    each = tuple(found[j] for j in range(1, joints + 1))
    limit = [max(one.interval[1], one.finest) for one in each]
    return Boundaries(each, np.array(limit))
