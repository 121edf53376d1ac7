"""An answer to a request that was given up comes late, and is taken for that of the next one."""

from __future__ import annotations

from types import SimpleNamespace

import canopen
import pytest
from canopen import SdoCommunicationError

from backends.canopen_cia402.remote import LATE_ANSWERS, NO_ANSWER, Remote, SetupError

LATE = "Node returned a value for 0x6502:00 instead"


class Slow:
    """A drive that stood still for a moment: so many answers are of other requests."""

    def __init__(self, late: int, says: str = LATE) -> None:
        self.late, self.says, self.asked = late, says, 0

    def upload(self, index: int, sub: int) -> bytes:
        self.asked += 1
        if self.asked <= self.late:
            raise SdoCommunicationError(self.says)
        return (0x603F).to_bytes(2, "little")

    def download(self, index: int, sub: int, data: bytes) -> None:
        self.upload(index, sub)


def remote(sdo: Slow) -> Remote:
    variable = canopen.objectdictionary.ODVariable("error", 0x603F)
    variable.data_type, variable.access_type = canopen.objectdictionary.UNSIGNED16, "rw"
    known = SimpleNamespace(get_variable=lambda index, sub: variable)
    return Remote(SimpleNamespace(sdo=sdo, object_dictionary=known))


@pytest.mark.parametrize("late", range(LATE_ANSWERS + 1))
def test_it_is_asked_again(late):
    assert remote(Slow(late)).read(0x603F) == 0x603F
    assert remote(Slow(late)).write(0x603F, 0x603F) is None


def test_who_mixes_answers_up_for_good_is_told():
    with pytest.raises(SetupError, match=r"no answer to SDO 0x603F:0: Node returned a value for"):
        remote(Slow(100)).read(0x603F)


def test_who_does_not_answer_is_not_asked_again():
    sdo = Slow(100, NO_ANSWER)
    with pytest.raises(SetupError):
        remote(sdo).read(0x603F)
    assert sdo.asked == 1


def test_silence_is_what_the_library_calls_it():
    client = canopen.sdo.SdoClient(0x601, 0x581, canopen.ObjectDictionary())
    client.RESPONSE_TIMEOUT = 0.001
    with pytest.raises(SdoCommunicationError) as told:
        client.read_response()
    assert str(told.value) == NO_ANSWER
