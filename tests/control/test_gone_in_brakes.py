"""How far a joint has gone in its closed brake, told from one that only reads elsewhere."""

import numpy as np

from pa10d.control.whereabouts import JUMP, GoneInBrakes

PERIOD, SPEED = 0.01, 1.0


class Limits:
    torque, velocity = np.ones(2), np.full(2, SPEED)


def gone(places, age=0, closed=True, rests=None):
    """After these places (rad) of the second joint, a period apart."""
    watch, still = GoneInBrakes(Limits()), np.zeros(2, dtype=np.int64)
    for k, place in enumerate(places):
        ages = still.copy()
        ages[1] = age if k == 2 else 0
        brakes = np.array([True, closed or k != 2])
        rest = True if rests is None else np.array([True, k >= rests])
        found = watch.see(k * PERIOD, np.array([0.3, place]), ages, brakes, rest)
    assert found[0] == 0.0
    return float(found[1])


def test_from_where_it_was_first_seen_there():
    assert np.isclose(gone([0.1, 0.11, 0.12, 0.13]), 0.03)
    assert np.isclose(gone([0.1, 0.11, 0.12, 0.13], rests=2), 0.01), "it came to rest there"


def test_what_reads_elsewhere_at_once_has_not_gone_there():
    far = 1.01 * JUMP * SPEED * PERIOD
    assert np.isclose(gone([0.1, 0.1, 0.1 + far, 0.11 + far]), 0.01)
    assert np.isclose(gone([0.1, 0.1, 0.1 + 0.9 * far, 0.11 + 0.9 * far]), 0.01 + 0.9 * far)


def test_nor_what_is_not_heard_or_out_of_its_brake():
    places = [0.1, 0.11, 0.12, 0.14]
    assert gone(places, age=1) == gone(places, closed=False) == 0.0
