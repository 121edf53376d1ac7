"""Small files that would become very large are refused before they do."""

from __future__ import annotations

import gzip
import time

import numpy as np
import pytest
from store_data import motion, plain_table, write_csv

from pa10d.common.errors import UserError
from pa10d.measurement.sampling import analyse
from pa10d.store import csv_locate
from pa10d.store.csv_import import read_csv


def test_a_last_stamp_years_later_is_named_and_costs_nothing(tmp_path):
    t, q, tau = motion(400)
    t[-1] = 1e9
    path = write_csv(tmp_path / "late.csv", plain_table(t, q, tau))
    began = time.monotonic()
    with pytest.raises(UserError, match=r"late\.csv: column time: found 1\.99 s and then 1e\+09"):
        read_csv(path, 2, "arm")
    assert time.monotonic() - began < 20


@pytest.mark.parametrize("last", [1e300, 1.7e308, 1e18])
def test_stamps_beyond_everything(last):
    t = np.append(np.arange(200) * 0.002, last)
    with pytest.raises(UserError, match="times the usual step"):
        analyse(t)


def test_stamps_that_are_no_seconds():
    with pytest.raises(UserError, match="expected seconds"):
        analyse(1.7e18 + np.arange(200) * 2e6)


def test_a_pause_of_half_an_hour_is_still_one_recording():
    t = np.concatenate([np.arange(2000) * 0.002, 1800 + np.arange(2000) * 0.002])
    assert analyse(t).gaps


def test_a_file_that_grows_a_thousandfold_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_locate, "SMALL", 1 << 20)
    path = tmp_path / "bomb.csv.gz"
    path.write_bytes(gzip.compress(b"time,q1,tau1\n" + b"0,0,0\n" * 2_000_000))
    with pytest.raises(UserError, match=r"bomb\.csv\.gz: \d+ compressed bytes become more than"):
        read_csv(path, 1, "arm")


def test_an_ordinary_compressed_file_is_welcome(tmp_path):
    path = write_csv(tmp_path / "plain.csv.gz", plain_table(*motion(400)))
    assert len(read_csv(path, 2, "arm").samples.q) == 400
