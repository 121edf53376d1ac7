"""Data sets of simulated arms with known answers."""

from backends.virtual.datasets.csvfile import write_csv
from backends.virtual.datasets.draws import random_effect
from backends.virtual.datasets.figures import Figures, NoPlace, figures_of
from backends.virtual.datasets.foreign import foreign_runs
from backends.virtual.datasets.robot import open_robot, reach_of
from backends.virtual.datasets.runs import KINDS, motion_of, run_motion
from backends.virtual.datasets.sets import make_runs

__all__ = [
    "KINDS",
    "Figures",
    "NoPlace",
    "figures_of",
    "foreign_runs",
    "make_runs",
    "motion_of",
    "open_robot",
    "random_effect",
    "reach_of",
    "run_motion",
    "write_csv",
]
