"""Worlds in which we say who runs when."""

from __future__ import annotations

import pytest
from world import World, profile_in


@pytest.fixture
def make_world(tmp_path, monkeypatch):
    """A new world of three joints, or of ``chosen`` ones; other keywords change its profile."""
    made = []

    def make(**changes):
        made.append(World(profile_in(tmp_path, **changes), tmp_path, monkeypatch.setattr))
        return made[-1]

    yield make
    for world in made:
        world.close()


@pytest.fixture
def world(make_world):
    return make_world()
