"""LabVIEW's measurement files as plain tables: headers above, a column for remarks at the right."""

from __future__ import annotations

from collections.abc import Sequence

END = "***End_of_Header***"
UNITS = "Y_Unit_Label"
REMARKS = "Comment"
MOST = 200  # lines within which the headers end


def bare_table(lines: Sequence[str]) -> list[str]:
    """Names, their units where the file tells them, and rows; the lines as they are where they are
    none of LabVIEW's."""
    ends = [k for k, line in enumerate(lines[:MOST]) if line.strip() == END]
    if not ends or ends[-1] + 1 >= len(lines):
        return list(lines)
    above, (names, *rows) = lines[: ends[-1]], lines[ends[-1] + 1 :]
    told = {key: rest for key, _, rest in (line.partition("\t") for line in above)}
    sign = "," if told.get("Separator", "").strip().lower() == "comma" else "\t"
    cells = names.split(sign)
    width = len(cells) - (cells[-1].strip() == REMARKS)
    units = ["", *told.get(UNITS, "").split("\t")][:width]
    below = [units + [""] * (width - len(units))] if any(map(str.strip, units)) else []
    table = [cells, *below, *(row.split(sign) for row in rows if row.strip())]
    return [sign.join(row[:width]) for row in table]
