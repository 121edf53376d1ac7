"""Reports: one HTML file each, that opens offline and answers what a person would ask next."""

from pa10d.report.blocks import Cards, Lines, Plot, Section, Table, Text
from pa10d.report.compare_page import compare_page
from pa10d.report.page import page

__all__ = ["Cards", "Lines", "Plot", "Section", "Table", "Text", "compare_page", "page"]
