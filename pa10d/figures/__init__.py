"""Figures, made once in Python as Plotly JSON: the report and the web page draw the same ones.

A figure is ``{"data": [...], "layout": {...}}``, strict JSON, without colours of its own for
paper, text and grid: whoever draws it adds the theme (``plots.js`` does).
"""

from pa10d.figures.errors import error_maps
from pa10d.figures.evidence import before_after, evidence, ranking
from pa10d.figures.memory import memory
from pa10d.figures.of_comparison import comparison_figures, joint_figures, units
from pa10d.figures.overview import overview
from pa10d.figures.spectra import spectra
from pa10d.figures.staircase import staircase, staircase_text
from pa10d.figures.texts import TEXTS, Reading
from pa10d.figures.time import torque_over_time, torque_plot

__all__ = [
    "TEXTS",
    "Reading",
    "before_after",
    "comparison_figures",
    "error_maps",
    "evidence",
    "joint_figures",
    "memory",
    "overview",
    "ranking",
    "spectra",
    "staircase",
    "staircase_text",
    "torque_over_time",
    "torque_plot",
    "units",
]
