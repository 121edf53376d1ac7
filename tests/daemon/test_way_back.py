"""An arm that stands outside its position limits, over HTTP and CAN: refused, brought back inside
where that is asked for, and moved as ever from then on."""

from __future__ import annotations

import pytest
from pushed_arm import LIMIT, pushed

from pa10d.client import ApiError

__all__ = ["pushed"]
SAYS = "joint 7 stands 0.0500 rad beyond its upper limit of 4.4506 rad"


def refusal(do, *arguments, **more):
    with pytest.raises(ApiError) as refused:
        do(*arguments, **more)
    assert refused.value.status == 409
    return str(refused.value)


@pytest.mark.long  # the page's test of the same sees it, too
def test_it_is_refused_and_brought_back_where_that_is_asked_for(pushed):
    with pushed(LIMIT + 0.05) as client:
        (stray,) = client.robot()["outside"]
        assert stray["sentence"] == SAYS
        assert not stray["too_far"]
        assert "ask for 'recover'" in refusal(client.enable)
        assert SAYS in refusal(client.experiment, "tracking")
        assert client.robot()["state"] == "inactive"
        robot = client.enable(recover=True)
        assert robot["state"] == "holding"
        assert robot["outside"] == []
        assert LIMIT - 0.05 < robot["axes"][6]["position"] < LIMIT
        client.disable()
        assert client.enable()["state"] == "holding"
        assert client.enable(recover=True)["state"] == "holding", "nothing to do"


@pytest.mark.long
def test_an_experiment_may_ask_for_it_too(pushed):
    with pushed(-LIMIT - 0.1) as client:
        found = client.experiment("tracking", {"period": 4.0, "cycles": 1}, recover=True)
        assert len(found["runs"]) == 1
        assert client.robot()["state"] == "inactive"


@pytest.mark.long  # the page's test of the same sees it, too
def test_too_far_out_nobody_powers_it(pushed):
    with pushed(LIMIT + 0.3) as client:
        assert client.robot()["outside"][0]["too_far"]
        said = refusal(client.enable, recover=True)
        assert "move it inside by hand" in said
        assert client.robot()["state"] == "inactive"
