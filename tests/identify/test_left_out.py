"""A stretch that is left out is in no fit and no judgement, and reaches neither of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from backends.virtual.datasets import make_runs
from pa10d.cli import main
from pa10d.common.errors import UserError
from pa10d.identify import FitOptions, identify
from pa10d.judgement import judge
from pa10d.measurement.recording import Recording
from pa10d.model.notes import LeftOutNote
from pa10d.services.library import open_library
from pa10d.services.models import identify_runs
from pa10d.services.robots import load_robot
from pa10d.store import Channels, RunStore, Samples

WRONG = (6.0, 8.0)  # s


@pytest.fixture(scope="module")
def clean():
    profile, robot = load_robot("pa10-sim")
    run = make_runs(2, [], "white", ("train_a",), profile, seconds=20.0)[0]["train_a"]
    return robot, run


def spoiled(run: Recording) -> Recording:
    """Somebody leaned on the arm: 40 N·m on every joint for two seconds."""
    tau = run.tau.copy()
    tau[(run.t - run.t[0] >= WRONG[0]) & (run.t - run.t[0] <= WRONG[1])] += 40.0
    return replace(run, tau=tau)


@pytest.mark.long
def test_a_spoiled_stretch_does_no_harm_once_it_is_left_out(clean):
    robot, run = clean
    good = identify([run.without([WRONG])], robot, name="good")
    bad = identify([spoiled(run)], robot, name="bad")
    mended = identify([spoiled(run).without([WRONG])], robot, name="mended")
    assert np.allclose(mended.h, good.h, rtol=1e-6, atol=1e-6)
    assert np.abs(bad.h - good.h).max() > 1.0
    told = judge(mended, [spoiled(run).without([WRONG])], mended.cutoff).rms
    same = judge(good, [run.without([WRONG])], mended.cutoff).rms
    assert np.allclose(told, same, rtol=1e-4)


def test_a_part_of_a_run_keeps_what_is_left_out_of_it(clean):
    run = clean[1].without([WRONG, (15.0, 16.0)])
    part = run.part(3500, 6000, " (part)")  # 7 to 12 s
    assert part.excluded == (pytest.approx((0.0, 1.0)),)
    assert part.left_out.sum() == pytest.approx(500, abs=2)
    assert np.array_equal(part.left_out, run.left_out[3500:6000])


def test_the_store_keeps_stretches_in_order_and_within_the_run(tmp_path):
    store = RunStore(tmp_path)
    t = np.arange(0, 10, 0.01)
    q = np.sin(t)[:, None]
    with store.building("one", "one", Channels(joints=("a",)), None) as writer:
        writer.append(Samples((t * 1e9).round().astype("int64"), q, q))
    changed = store.change("one", excluded=[(5, 6), (1, 2), (5.5, 7)])
    assert changed.excluded == ((1, 2), (5, 7))
    assert RunStore(tmp_path).recording("one").left_out.sum() == pytest.approx(302, abs=2)
    for wrong in ((3, 3), (-1, 2), (9, 12)):
        with pytest.raises(UserError, match=r"expected a stretch within 0 to 9\.99"):
            store.change("one", excluded=[wrong])
    assert store.change("one", excluded=[]).excluded == ()


@pytest.fixture
def stored(tmp_path, clean):
    """The same, spoiled, in a store."""
    robot, run = clean
    library = open_library(tmp_path)
    stamps = (run.t * 1e9).round().astype("int64")
    channels = Channels(joints=robot.joint_names)
    profile = load_robot("pa10-sim")[0]
    with library.runs.building("one", "one", channels, profile) as writer:
        writer.append(Samples(stamps, run.q, spoiled(run).tau))
    return library, str(profile.path)


@pytest.mark.long
def test_one_fit_leaves_out_what_others_use(stored):
    library, profile = stored
    bad = identify_runs(library, ["one"], profile, name="bad", options=FitOptions(10.0))
    good = identify_runs(
        library, ["one"], profile, name="good", options=FitOptions(10.0), left_out=[("one", *WRONG)]
    )
    assert max(good.info.rms) < 0.2 * max(bad.info.rms)
    assert good.model.notes.left_out == (LeftOutNote("one", 6.0, 8.0),)
    assert library.runs.find("one").excluded == (), "the run stays as it was"


@pytest.mark.parametrize(
    ("stretch", "says"),
    [
        (("one", 3.0, 99.0), "expected a stretch within 0 to 19"),
        (("none", 3.0, 4.0), "none"),
    ],
)
def test_a_stretch_that_is_none_is_refused(stored, stretch, says):
    library, profile = stored
    with pytest.raises(UserError, match=says):
        identify_runs(library, ["one"], profile, name="m", left_out=[stretch])
    assert not library.models.all()


def test_a_time_on_the_command_line_is_a_number(tmp_path, capsys):
    command = ["identify", "one", "--name", "m", "--leave-out", "one", "3", "x"]
    assert main(["--data", str(tmp_path), *command]) != 0
    assert "--leave-out one 3 x: expected a run and two times" in capsys.readouterr().err
