"""Broken CSV files: one line that names file, line and column."""

from __future__ import annotations

import gzip

import pytest
from store_data import motion, plain_table, write_csv

from pa10d.common.errors import UserError
from pa10d.store.csv_import import read_csv

HEAD = "time,q1,q2,tau1,tau2"
ROWS = [
    ",".join(map(repr, row))
    for row in zip(*(c.tolist() for c in plain_table(*motion()).values()), strict=True)
]


def _with(line, text):
    rows = [HEAD, *ROWS]
    rows[line - 1] = text
    return "\n".join(rows) + "\n"


def _cell(line, column, text):
    cells = ROWS[line - 2].split(",")
    cells[column] = text
    return _with(line, ",".join(cells))


def _with_powers(columns, power):
    rows = [row.split(",") for row in ROWS]
    for row in rows:
        for k in columns:
            row[k] += power
    return "\n".join([HEAD, *map(",".join, rows)]) + "\n"


def _torques(power):
    return _with_powers([3, 4], power)


def _stamps(power):
    return _with_powers([0], power)


BROKEN = {
    "empty file": ("", ": an empty file; expected a header"),
    "header alone": (HEAD + "\n", ": found 0 samples, expected at least 100"),
    "few samples": ("\n".join([HEAD, *ROWS[:99]]), ": found 99 samples, expected at least 100"),
    "first line empty": ("\n" + HEAD + "\n", ":1: an empty line; expected a header"),
    "no header": ("\n".join(ROWS), ":1: found numbers, expected a header"),
    "semicolons": (_with(1, HEAD).replace(",", ";"), ":1: columns are parted by semicolons"),
    "tabs": (_with(1, HEAD).replace(",", "\t"), ":1: columns are parted by tabs"),
    "no time": (_with(1, "Time,q1,q2,tau1,tau2"), ":1: no column time; found Time, q1"),
    "no tau2": (_with(1, "time,q1,q2,tau1,x"), ":1: no column tau2; found time, q1, q2, tau1, x"),
    "no names": (_with(1, ",,,,"), ":1: no column time, q1, q2, tau1, tau2; found no names in its"),
    "column twice": (_with(1, "time,q1,q1,tau1,tau2"), ":1: columns 2 and 3 are both 'q1'"),
    "text": (_cell(57, 3, "fast"), ":57: column 4 (tau1): found 'fast', expected a finite number"),
    "empty cell": (_cell(3, 1, ""), ":3: column 2 (q1): found an empty cell, expected a finite"),
    "nan": (_cell(201, 2, "nan"), ":201: column 3 (q2): found 'nan', expected a finite number"),
    "NULL": (_cell(5, 2, "NULL"), ":5: column 3 (q2): found 'NULL', expected a finite number"),
    "infinite": (_cell(9, 4, "-inf"), ":9: column 5 (tau2): found '-inf', expected a finite"),
    "no sensor's": (_cell(9, 4, "1e308"), ":9: column 5 (tau2): found '1e308', expected a finite"),
    "scaled to nothing": (_torques("e-300"), ": the torque of joint 1 is "),
    "no time passes": (
        _stamps("e-300"), ": column time: found steps of 5e-303 s, expected seconds"
    ),
    "decimal comma": (_cell(12, 1, "0,5"), ":12: found 6 columns, expected 5"),
    "quoted decimal comma": (_cell(12, 1, '"0,5"'), ":12: column 2 (q1): found '0,5', expected"),
    "underscore": (_cell(8, 1, "1_0"), ":8: column 2 (q1): found '1_0', expected a finite number"),
    "row too long": (_with(100, ROWS[98] + ",7"), ":100: found 6 columns, expected 5"),
    "row too short": (_with(44, "0.2,1,1,1"), ":44: found 4 columns, expected 5"),
    "cut off": (_with(1, HEAD)[:-30], ":401: found "),
    "backwards": (_cell(102, 0, "0.1"), ":102: column time: found 0.1 after 0.495, expected"),
    "a word between": (_with(20, "pause"), ":20: found 1 columns, expected 5"),
}  # fmt: skip


@pytest.mark.parametrize("packed", [False, True], ids=["csv", "csv.gz"])
@pytest.mark.parametrize("case", BROKEN)
def test_one_line_says_where_and_what(tmp_path, case, packed):
    text, said = BROKEN[case]
    path = tmp_path / ("a.csv.gz" if packed else "a.csv")
    path.write_bytes(gzip.compress(text.encode()) if packed else text.encode())
    message = _refused(path)
    assert message.startswith(f"{path}{said}")


def _refused(path, n=2, **more):
    with pytest.raises(UserError) as error:
        read_csv(path, n, "arm", **more)
    message = str(error.value)
    assert "\n" not in message
    assert "expected" in message
    return message


def test_a_file_cut_off_in_its_last_line_says_so(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(_with(1, HEAD)[:-45])
    assert _refused(path).endswith("was the file cut off?")


def test_not_utf8(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(_cell(31, 2, "@").encode().replace(b"@", b"\xb5"))
    assert _refused(path).startswith(f"{path}:31: byte 0xb5 is not UTF-8; expected a text file")
    path.write_bytes(_with(1, HEAD).encode("utf-16"))
    assert _refused(path).startswith(f"{path}:1: byte 0xff is not UTF-8")


@pytest.mark.parametrize("share", [0.02, 0.5, 0.999])
def test_a_truncated_gz(tmp_path, share):
    path = write_csv(tmp_path / "a.csv.gz", plain_table(*motion(3000)))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    message = _refused(path)
    assert "the compressed data end or are damaged here; expected a whole .gz file" in message


def test_a_damaged_gz(tmp_path):
    path = write_csv(tmp_path / "a.csv.gz", plain_table(*motion(3000)))
    data = bytearray(path.read_bytes())
    data[-6] ^= 255
    path.write_bytes(data)
    assert "the compressed data end or are damaged here" in _refused(path)


def test_named_gz_but_plain_text_is_read(tmp_path):
    path = tmp_path / "a.csv.gz"
    path.write_text(_with(1, HEAD))
    assert len(read_csv(path, 2, "arm").samples) == 400


def test_no_such_file_and_a_folder(tmp_path):
    assert _refused(tmp_path / "no.csv").startswith(f"{tmp_path}/no.csv: No such file")
    assert _refused(tmp_path).startswith(f"{tmp_path}: Is a directory")


def test_a_robot_with_more_joints_names_all_missing_columns(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(_with(1, HEAD))
    message = _refused(path, n=4)
    assert ":1: no column q3, q4, tau3, tau4; found time, q1, q2, tau1, tau2; expected" in message
    assert "q1..q4, tau1..tau4 for the 4 joints of arm" in message


def test_a_hint_where_a_name_is_nearly_right(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(_with(1, "timestamp,q1,q2,Tau1,tau2"))
    assert "perhaps --map timestamp=time" in _refused(path)
    path.write_text(_with(1, "time,q1,q2,Tau1,tau2"))
    assert "perhaps --map Tau1=tau1" in _refused(path)


@pytest.mark.parametrize(
    ("mapping", "said"),
    [
        (["q1"], "--map q1: expected COLUMN=FIELD"),
        (["x=q0"], "--map x=q0: expected COLUMN=FIELD"),
        (["x=velocity1"], "--map x=velocity1: expected COLUMN=FIELD"),
        (["a=q1", "b=q1"], "--map b=q1: found a second time"),
        (["nothing=q1"], ":1: no column 'nothing', expected by --map; found time"),
        (["q2=q1"], ":1: columns 2 and 3 are both 'q1'"),
    ],
)
def test_mappings_that_cannot_be(tmp_path, mapping, said):
    path = tmp_path / "a.csv"
    path.write_text(_with(1, HEAD))
    assert said in _refused(path, mapping=mapping)


@pytest.mark.long
def test_the_line_is_right_far_down_a_large_file(tmp_path):
    """Beyond Arrow's first blocks, with empty lines before it."""
    table = plain_table(*motion(120_000))
    path = write_csv(tmp_path / "a.csv", table)
    lines = path.read_text().splitlines()
    lines[110_000] = lines[110_000].replace(",", ",x", 1)
    lines[5:5] = ["", "", ""]
    path.write_text("\n".join(lines))
    assert _refused(path).startswith(f"{path}:110004: column 2 (q1): found 'x")
