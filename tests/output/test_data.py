"""Results as dictionaries and as tables of pandas."""

import copy
import dataclasses
import json
import math
import sys
from dataclasses import dataclass, is_dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.output.data import DataResult, TableResult

INSIDE_OTHERS = {"BoundLaw", "ByLaw", "OperatingPoints"}
"""Classes of `results` that only others hold."""


class Frame(dict):
    """What stands for ``pandas.DataFrame``: columns of one length."""

    def __init__(self, columns):
        super().__init__({name: list(column) for name, column in columns.items()})
        self.lengths = {len(column) for column in self.values()}


@dataclass(frozen=True)
class Numbers(DataResult):
    many: np.ndarray
    alone: float
    named: dict


@pytest.fixture
def pandas(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=Frame))


def test_every_result_is_handed_over_as_a_dictionary(of_each_kind):
    for name, result in of_each_kind.items():
        if name != "average":
            said = json.loads(json.dumps(result.to_dict(), allow_nan=False))
            assert said, name
    without = {name for name in ss.results.__all__ if is_dataclass(kind := getattr(ss.results, name))
               and not hasattr(kind, "to_dict")}  # fmt: skip
    assert without <= INSIDE_OTHERS


def test_tables_have_columns_of_one_length(of_each_kind, pandas):
    tables = {name: result for name, result in of_each_kind.items() if isinstance(result, TableResult)}
    assert {"threshold", "thresholds", "trajectory", "map", "basins"} <= set(tables)
    for name, result in tables.items():
        frame = result.to_pandas()
        assert len(frame.lengths) == 1, name
        assert frame.lengths != {0}, name


def test_a_table_holds_the_results_own_numbers(of_each_kind, pandas):
    thresholds = of_each_kind["thresholds"]
    frame = thresholds.to_pandas()
    assert frame["value"] == np.ravel(thresholds.value).tolist()
    assert frame["V"] == pytest.approx(np.linspace(0.1, 1.0, 30).tolist())
    found = of_each_kind["map"]
    cells = found.to_pandas()
    for row, column in np.ndindex(found.motion.shape):
        at = row * found.motion.shape[1] + column
        assert (cells["V"][at], cells["alpha"][at]) == (found.x.values[column], found.y.values[row])
        assert cells["motion"][at] == found.motion[row, column].value


@pytest.mark.parametrize(
    ("make", "rows"),
    [
        (lambda study: study.margins, lambda study: len(study.margins.rows)),
        (lambda study: ss.critical(study.law, "mu_s", study.oscillator), lambda _: 1),
        (lambda study: ss.results.Comparison("a threshold", study.answers), lambda study: len(study.answers)),
        (lambda _: ss.fit([0.1 * i for i in range(9)], [0.4 - 0.02 * i for i in range(9)], laws="linear"),
         lambda _: 1),
    ],
    ids=["margins", "critical", "comparison", "fits"],
)  # fmt: skip
def test_each_line_of_a_table_is_a_row(make, rows, of_each_kind, pandas):
    study = of_each_kind["study"]
    result = make(study)
    assert result.to_pandas().lengths == {rows(study)}
    assert json.dumps(result.to_dict(), allow_nan=False)


def test_a_table_without_pandas_says_what_to_install(of_each_kind, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ss.InputError, match=r"pip install pandas; or take to_dict\(\)"):
        of_each_kind["trajectory"].to_pandas()


@pytest.mark.parametrize("name", ["thresholds", "unknown", "map", "basins", "threshold", "regime", "rest", "step"])
def test_results_that_say_the_same_are_equal(name, of_each_kind):
    result = of_each_kind[name]
    again = copy.deepcopy(result)
    assert again == result
    assert np.all(result != name)


@pytest.mark.parametrize(
    ("name", "field"),
    [("thresholds", "value"), ("map", "attractors"), ("thresholds", "error")],
)
def test_results_that_differ_in_one_number_are_not_equal(name, field, of_each_kind):
    result = of_each_kind[name]
    changed = copy.deepcopy(getattr(result, field))
    array = next(iter(changed.values())) if isinstance(changed, dict) else changed
    array.setflags(write=True)
    first = (0,) * array.ndim
    array[first] = 1.0 - array[first] if array.dtype != bool else not array[first]
    assert dataclasses.replace(result, **{field: changed}) != result


def test_numbers_that_are_not_known_are_the_same_where_the_results_are():
    nothing = Numbers(np.array([math.nan, 1.0]), math.nan, {"a": [1.0, None]})
    assert nothing == copy.deepcopy(nothing)
    assert nothing != dataclasses.replace(nothing, alone=0.0)
    assert nothing != dataclasses.replace(nothing, many=np.array([math.nan, 2.0]))
    assert nothing != dataclasses.replace(nothing, named={"a": [1.0, 0.0]})


def test_a_result_that_holds_functions_is_equal_to_itself_alone(of_each_kind):
    trajectory = of_each_kind["trajectory"]
    assert trajectory == trajectory
    assert trajectory != copy.copy(trajectory)
    assert len({trajectory, trajectory}) == 1


def test_a_quantity_equals_its_value_and_another_result_that_says_the_same(of_each_kind):
    one, many = of_each_kind["threshold"], of_each_kind["thresholds"]
    assert one == one.value
    assert (one != one.value) is False
    assert one != one.value + 1.0
    assert hash(one) == hash(one.value)
    assert (many == many.value).all()
    assert (many != many.value.max()).sum() == many.value.size - 1
    assert one != dataclasses.replace(one, relative_error=0.5)
    assert one != many
