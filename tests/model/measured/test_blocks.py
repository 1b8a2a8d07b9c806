"""Files of several tables: a preamble, a header and rows for each step of a machine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss


def curve(v):
    return 0.2 + 0.3 * np.exp(-3 * v)


def table(v, mu, header="Time (s),Sliding Speed (mm/s),COF", unit=1000):
    return [header, *(f"{5 * i},{unit * a:.6g},{b:.5f}" for i, (a, b) in enumerate(zip(v, mu, strict=True)))]


def write(folder, *lines):
    path = folder / "steps.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@given(st.integers(0, 2**32))
def test_steps_of_one_header_are_one_sweep(tmp_path_factory, seed):
    """Each step alone and all together are the rows that were written, whatever stands between them."""
    rng = np.random.default_rng(seed)
    lines, steps = ["Machine 9", "Number of steps,3"], []
    for number in range(1, int(rng.integers(2, 5)) + 1):
        v = np.round(np.sort(rng.uniform(0.02, 1.2, int(rng.integers(3, 9)))), 4)
        units = ["s,mm/s,-"] if rng.random() < 0.3 else []
        header, *rows = table(v, curve(v))
        if units:
            header = "Time,Sliding Speed,COF"
        steps.append((header, v, np.round(curve(v), 5)))
        lines += ["", f"Step {number} of a test,kind,{number}", "Load (N),20", header, *units, *rows]
    path = write(tmp_path_factory.mktemp("steps"), *lines)
    kinds = {header for header, _, _ in steps}
    if len(kinds) == 1:
        read = ss.read_measurements(path)
        order = np.argsort(np.concatenate([v for _, v, _ in steps]), kind="stable")
        assert read.v == pytest.approx(np.concatenate([v for _, v, _ in steps])[order], rel=1e-12)
        assert read.mu.tolist() == np.concatenate([mu for _, _, mu in steps])[order].tolist()
    else:
        with pytest.raises(ss.InputError, match="holds tables with different headers"):
            ss.read_measurements(path)
    for number, (_, v, mu) in enumerate(steps, 1):
        read = ss.read_measurements(path, block=number)
        assert read.v == pytest.approx(v, rel=1e-12)
        assert read.mu.tolist() == mu.tolist()
        block = read.blocks[number - 1]
        assert (block.number, block.rows, block.read) == (number, len(v), True)
        assert block.label.startswith(f"Step {number} of a test")
        assert len(read.blocks) == len(steps)


def test_blocks_that_contradict_are_refused_with_the_command_that_reads_one(tmp_path):
    v = np.linspace(0.1, 1, 10)
    path = write(tmp_path, "Step 1", *table(v, curve(v)), "", "Step 2", *table(v, 0.5 * curve(v)))
    with pytest.raises(ss.InputError, match=r"from 0.1 to 1 m/s mu is 0.28. and 0.14. on average") as refusal:
        ss.read_measurements(path)
    assert str(refusal.value).endswith(f"read_measurements({str(path)!r}, block=1)")
    second = ss.read_measurements(path, block=2)
    assert second.mu.tolist() == np.round(0.5 * curve(v), 5).tolist()
    varies = "Sliding Speed (mm/s) 100 to 1000, COF 0.2149 to 0.4223"
    assert f"block 1 (line 2, 'Step 1', 10 rows: {varies}), not read" in second.preview()
    apart = write(tmp_path, "Step 1", *table(v, curve(v)), "", "Step 2", *table(v + 2, 0.5 * curve(v)))
    assert len(ss.read_measurements(apart)) == 20  # no speed is shared


def test_each_step_has_its_radius(tmp_path):
    v = np.linspace(0.1, 1, 10)
    steps = []
    for radius in (0.02, 0.03):
        rows = table(v, curve(v), "Time (s),Speed (rad/s),COF", 1 / radius)
        steps += [f"Step at {1000 * radius:g} mm", f"Track radius (mm),{1000 * radius:g}", *rows, ""]
    path = write(tmp_path, *steps)
    read = ss.read_measurements(path)
    assert read.v == pytest.approx(np.repeat(v, 2), rel=1e-5)
    assert "radius 20 mm from line 2, radius 30 mm from line 16" in str(read)
    with pytest.raises(ss.InputError, match="has blocks 1 to 2, and no block 3"):
        ss.read_measurements(path, block=3)


def test_a_table_that_is_no_block_is_no_row_either(tmp_path):
    v = np.linspace(0.1, 1, 10)
    path = write(tmp_path, *table(v, curve(v)), "Sliding Speed (mm/s),Friction Force,Note", "no numbers here")
    with pytest.raises(ss.InputError, match="line 12"):
        ss.read_measurements(path)
