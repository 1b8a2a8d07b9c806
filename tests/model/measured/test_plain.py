"""Long files of plain numbers are read as a whole: as their cells, one by one, would be."""

from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.model.measured import sweep_branches, text_table
from stickslip_sym.model.measured.plain import plain_numbers

HEADERS = (
    ("v [m/s]", "mu"), ("v [mm/s]", "mu"), ("Time [s]", "v [mm/s]", "mu"), ("v [m/s]", "F_t [N]", "F_n [N]"),
    ("mu", "Speed [rpm]", "X"), (),
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("plain")


def both_ways(path, **how):
    """What is read as a whole, and what cell by cell."""
    results = []
    for least in (0, 1e9):
        with patch.object(text_table, "ROWS_TO_SAMPLE", least):
            try:
                results.append(ss.read_measurements(path, **how))
            except ss.InputError as error:
                results.append(str(error))
    return results


@given(st.integers(0, 2**32))
def test_plain_files_are_read_as_their_cells(folder, seed):
    rng = np.random.default_rng(seed)
    header, mark = HEADERS[rng.integers(len(HEADERS))], ",;\t "[rng.integers(4)]
    count = int(rng.integers(12, 60))
    v = np.round(rng.uniform(0.01, 90, count), int(rng.integers(1, 6)))
    mu = np.round(0.2 + 0.3 * np.exp(-v / 20) + 0.002 * rng.normal(size=count), 4)
    by_name = {"mu": mu, "F_t [N]": np.round(20 * mu, 4), "F_n [N]": np.full(count, 20.0)}
    columns = [by_name.get(name, v) for name in header] or [v, mu]
    ending = "\r\n" if rng.random() < 0.3 else "\n"
    lines = [mark.join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True)]
    faults = ["", "", "1e3,x", "# note", "-999,0.3", "0.5,", "0.5,0.3,0.1,7", "0,4;0,3", "1.5 0.3"]
    if fault := faults[rng.integers(len(faults))]:
        lines.insert(int(rng.integers(1, len(lines))), fault.replace(",", mark) if rng.random() < 0.5 else fault)
    path = folder / "rows.csv"
    preamble = ["Machine 9", "Track radius: 25 mm"] if header else []
    named = [mark.join(name.replace(" ", "") for name in header)] if header else []
    path.write_bytes(ending.join([*preamble, *named, *lines, ""]).encode())
    whole, cells = both_ways(path, leave_out=bool(rng.random() < 0.3))
    if isinstance(cells, str):
        assert whole == cells
    else:
        assert str(whole) == str(cells)
        for one, other in ((whole.v, cells.v), (whole.mu, cells.mu)):
            np.testing.assert_allclose(one, other, rtol=4e-16, atol=0)


def test_what_is_no_plain_number_is_left_to_cells():
    assert plain_numbers(b"1,2\n3.5,-4e-1\n", ",", 2).tolist() == [[1, 2], [3.5, -0.4]]
    for body in (b"1,2\n3\n", b"1,2\n3,4,5\n6\n", b"1,,2\n3,4\n", b"1,2\n\n3,4\n", b"1-2,\n3,4\n", b"1,-\n2,3\n",
                 b"1,999\n", b"1,1e31\n", b"1,1e999\n", b"# 1\n1,2\n", b"1,0x1\n", b"1,2\r3,4\n", b"", b"1 2,3\n",
                 b"1,nan\n", b"1,2,\n3,4,\n", b",1,2\n"):  # fmt: skip
        assert plain_numbers(body, ",", 2) is None, body
    assert plain_numbers(b"1, 2\n3, 4\n", ",", 2).tolist() == [[1, 2], [3, 4]]


def test_random_order_of_many_rows_is_no_sweep_and_sweeps_are():
    rng = np.random.default_rng(1)
    v = rng.uniform(0, 1, 60_000)
    assert sweep_branches._is_shuffled(v)
    swept = np.abs(np.sin(np.linspace(0, 2000, 60_000)))
    assert not sweep_branches._is_shuffled(swept)
    labels, rising, falling = sweep_branches._sweeps(swept)
    assert (rising, falling) == (637, 636)
    assert np.mean(labels[1:] == np.sign(np.diff(swept))) > 0.99
