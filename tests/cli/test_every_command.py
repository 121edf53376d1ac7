"""Every command answers what it cannot do with a status and one line, never with a traceback."""

from __future__ import annotations

import signal

import numpy as np
import pytest
from test_run_commands import URDF

from pa10d.cli import main, whole_parser
from pa10d.daemon import timekeeping
from pa10d.profile import load_profile

CANNOT, USAGE = 1, 2
WRONG = [  # words as typed, status, what the line speaks of
    ("case-study --seed x", USAGE, "--seed"),
    ("case-study --report nowhere/x.html", CANNOT, "--report nowhere/x.html: no such folder"),
    ("completion tcsh", USAGE, "tcsh"),
    ("serve --profile none.yaml", CANNOT, "none.yaml"),
    ("serve --port 99999999", USAGE, "99999999"),
    ("serve --hide fairies", CANNOT, "fairies"),
    ("experiment fly", CANNOT, "fly"),
    ("experiment --plan none.yaml", CANNOT, "none.yaml"),
    ("experiment point_to_point --set seed=[", USAGE, "--set seed: found '['"),
    ("experiment point_to_point --set seed=2001-99-99", USAGE, "--set seed: found"),
    ("weigh begin --weight abc", USAGE, "--weight: weight 'abc': expected MASS,X,Y,Z"),
    ("weigh guide --weight 2,x,0,0", USAGE, "--weight: weight '2,x,0,0'"),
    ("scale --alone --payload abc rec", USAGE, "--payload: weight 'abc'"),
    ("scale --alone --payload 3,0,0,0.1 rec --at-hand nan,0,0,0", USAGE, "--at-hand: weight"),
    ("experiment --plan bomb.yaml", CANNOT, "bomb.yaml"),
    ("experiment point_to_point --set seed=red", CANNOT, "seed"),
    ("experiment point_to_point --model none", CANNOT, "none"),
    ("controller feed_forward --model none", CANNOT, "no daemon runs on this data"),
    ("check --profile none.yaml", CANNOT, "none.yaml"),
    ("check --seconds -1", USAGE, "--seconds"),
    ("check --seconds inf", USAGE, "--seconds"),
    ("sim --profile none.yaml", CANNOT, "none.yaml"),
    ("demo --hide fairies", CANNOT, "fairies"),
    ("demo --hide stribeck:40", CANNOT, "40"),
    ("demo --profile none.yaml", CANNOT, "none.yaml"),
    ("demo --report nowhere/x.html", CANNOT, "--report nowhere/x.html: no such folder"),
    ("diagnose none --fit rec", CANNOT, "none"),
    ("add none stribeck --fit rec --name m1", CANNOT, "none"),
    ("improve none --fit rec --name m1", CANNOT, "none"),
    ("drives errors --profile none.yaml", CANNOT, "none.yaml"),
    ("drives clear --profile none.yaml", CANNOT, "none.yaml"),
    ("drives confirm --profile none.yaml", CANNOT, "none.yaml"),
    ("effect list --draws 3", USAGE, "--draws"),
    ("effect new 3d", CANNOT, "3d"),
    ("effect new ../x", CANNOT, "../x"),
    ("effect check fairies", CANNOT, "fairies"),
    ("effect page fairies", CANNOT, "fairies"),
    ("excite --profile none.yaml", CANNOT, "none.yaml"),
    ("excite --seconds x", USAGE, "--seconds"),
    ("excite --seconds -3 --profile two.yaml", USAGE, "--seconds"),
    ("excite --joints 9 --profile two.yaml", CANNOT, "joint"),
    ("investigate --fit none --profile two.yaml", CANNOT, "none"),
    ("investigate --resume none", CANNOT, "none"),
    ("investigate --minutes -3", USAGE, "minutes"),
    ("model list extra", USAGE, "extra"),
    ("model show none", CANNOT, "none"),
    ("model history none", CANNOT, "none"),
    ("model report none", CANNOT, "none"),
    ("model export none --format urdf", CANNOT, "none"),
    ("identify none --name m1", CANNOT, "none"),
    ("identify rec --name ../m1 --profile two.yaml", CANNOT, "../m1"),
    ("identify rec --name m1 --cutoff -4 --profile two.yaml", CANNOT, "cut-off -4"),
    ("compare none rec", CANNOT, "none"),
    ("profile new none.urdf", CANNOT, "none.urdf"),
    ("profile list extra", USAGE, "extra"),
    ("profile show --profile none.yaml", CANNOT, "none.yaml"),
    ("profile tune no.such.setting=3 --profile two.yaml", CANNOT, "no.such.setting"),
    ("profile undo --profile two.yaml", CANNOT, "two"),
    ("profile versions --profile none.yaml", CANNOT, "none.yaml"),
    ("robot state", CANNOT, "no daemon runs on this data"),
    ("robot enable extra", USAGE, "extra"),
    ("robot enable", CANNOT, "no daemon runs on this data"),
    ("robot stop", CANNOT, "no daemon runs on this data"),
    ("robot disable --anyhow", USAGE, "--anyhow"),
    ("robot disable", CANNOT, "no daemon runs on this data"),
    ("robot reset", CANNOT, "no daemon runs on this data"),
    ("run import none.csv --profile two.yaml", CANNOT, "none.csv"),
    ("run import two.yaml --profile two.yaml", CANNOT, "two.yaml"),
    ("run preview none.csv --profile two.yaml", CANNOT, "none.csv"),
    ("run list extra", USAGE, "extra"),
    ("run show none", CANNOT, "none"),
    ("run check none --profile two.yaml", CANNOT, "none"),
    ("run export none --format csv", CANNOT, "none"),
    ("run repair extra", USAGE, "extra"),
    ("run delete none", CANNOT, "none"),
    ("scale --payload none --empty rec --profile two.yaml", USAGE, "none"),
    ("schema fairies", CANNOT, "fairies"),
    ("track none", CANNOT, "none"),
    ("weigh guide --weight 1,0,0,0 --profile none.yaml", CANNOT, "none.yaml"),
    ("weigh begin --weight x", USAGE, "x"),
    ("weigh record none", CANNOT, "none"),
    ("weigh show none", CANNOT, "none"),
    ("weigh apply none", CANNOT, "none"),
    ("weigh undo none", CANNOT, "none"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A profile, a recording, and a data folder with that one run."""
    place = tmp_path_factory.mktemp("every_command")
    (place / "two.urdf").write_text(URDF)
    (place / "two.yaml").write_text("urdf: two.urdf\n")
    bomb = [f"k{k}: &k{k} [{', '.join([f'*k{k - 1}'] * 9)}]" for k in range(1, 10)]
    (place / "bomb.yaml").write_text("\n".join(["kind: tracking", "k0: &k0 1", *bomb]))
    t = np.arange(1000) / 200
    table = np.stack([t, 0.8 * np.sin(t), np.cos(2 * t), np.sin(t), np.cos(t)], axis=1)
    np.savetxt(place / "rec.csv", table, delimiter=",", header="time,q1,q2,tau1,tau2", comments="")
    words = ["run", "import", str(place / "rec.csv"), "--profile", str(place / "two.yaml")]
    assert main(["--data", str(place / "data"), *words]) == 0
    (place / "data" / "profile.json").unlink(missing_ok=True)  # what was used last is said, too
    return place


@pytest.fixture
def place(folder, monkeypatch):
    """Stood in, while a command is typed there."""
    monkeypatch.setenv("PA10D_DATA", str(folder / "data"))
    monkeypatch.chdir(folder)
    ends = signal.getsignal(signal.SIGTERM)
    yield folder
    signal.signal(signal.SIGTERM, ends)  # a story sets it


def _files(place):
    return {path for path in place.rglob("*") if path.is_file() and path.name != ".lock"}


@pytest.mark.parametrize(("typed", "status", "about"), WRONG, ids=[typed for typed, *_ in WRONG])
def test_bad_input_is_a_status_and_one_line(place, capfd, typed, status, about):
    before = _files(place)
    try:
        found = main(typed.split())
    except SystemExit as stop:
        found = stop.code
    said = capfd.readouterr()
    assert (found, said.out) == (status, "")
    *before_it, line = said.err.splitlines()
    assert about in line
    assert status == USAGE or all(told.endswith("base parameters") for told in before_it)
    assert "Traceback" not in said.err
    assert _files(place) == before


@pytest.mark.parametrize("looks", [[0.0, 0.01], [0.01, 0.0]], ids=["busy later", "busy at first"])
def test_a_machine_that_is_looked_at_is_not_told_of_where_nothing_starts(
    place, capfd, monkeypatch, looks
):
    """Nor is it looked at twice, each time with another outcome."""
    late = iter(looks)
    monkeypatch.setattr(timekeeping, "_bare_loop", lambda period, _: np.full(9, next(late)))
    profile = load_profile("pa10-sim")
    assert profile.simulation.clock == "real", "nothing would be looked at"
    test_bad_input_is_a_status_and_one_line(place, capfd, "serve --hide fairies", CANNOT, "fairies")
    assert len(list(late)) == 1


def test_no_command_is_left_out():
    known = {leaf.prog.removeprefix("pa10d ") for leaf in whole_parser().leaves()}
    tried = {name for name in known for typed, *_ in WRONG if (typed + " ").startswith(name + " ")}
    assert known == tried


def test_no_option_hides_what_every_command_has():
    """A word of ``experiment`` did: its ``--plan`` was refused for having a KIND as well."""
    for leaf in whole_parser().leaves():
        own = {action.dest for action in leaf._actions}
        assert own.isdisjoint({"run", "patient", "answers", "parser", "remembers", "writes"})
