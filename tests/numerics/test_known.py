"""What is not known is no value: nothing decides by it unless it is asked."""

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.core.remedies import Argument
from stickslip_sym.numerics.known import Column, Unknown, attempted, required

WHY, OTHER = Unknown("too many steps; try ", Argument("rtol", 1e-6)), Unknown("it left the table")


def test_nothing_takes_the_unknown_for_a_value():
    for use in (bool, float, lambda x: x == 0, lambda x: x != 0, lambda x: x < 1, lambda x: x >= 1, lambda x: -x):
        with pytest.raises(TypeError):
            use(WHY)
    with pytest.raises(TypeError):
        WHY in [0.0]  # noqa: B015
    assert WHY in [OTHER, Unknown(*WHY.reason)]


def test_a_reason_is_the_message_of_an_error_with_its_remedy():
    with pytest.raises(ss.NotConverged, match=r"^too many steps; try rtol=1e-06$") as error:
        required(WHY)
    assert error.value.remedies == (Argument("rtol", 1e-6),)
    assert [required(x) for x in (0.0, None, False)] == [0.0, None, False]

    def failing(*reason):
        raise ss.NoThreshold(*reason)

    assert attempted(failing, *WHY.reason) == WHY
    with pytest.raises(ss.OutOfTime):
        attempted(lambda: (_ for _ in ()).throw(ss.OutOfTime("late")))
    assert attempted(lambda: WHY) is WHY


def column():
    """Three numbers with errors 0.1, the second of which has bounds only, the third not even these."""
    values, low, high = np.array([1.0, np.nan, np.nan]), np.array([0, 2, -np.inf]), np.array([0, 3, np.inf])
    return Column.of(values, 0.1, WHY, low=low, high=high)


def test_what_is_claimed_and_what_is_excluded_follow_from_bounds():
    rows = column()
    assert rows.surely(above=0.5).tolist() == [True, True, False]
    assert rows.perhaps(above=2.5).tolist() == [False, True, True]
    assert rows.surely(above=0.5, below=1.05).tolist() == [False, False, False]
    assert rows.perhaps(above=1.05, below=1.5).tolist() == [True, False, True]
    assert rows.known.tolist() == [True, False, False]
    assert rows.errors == pytest.approx([0.1, 0.5, np.inf])
    assert rows.filled(7.0).tolist() == [1, 7, 7]
    with pytest.raises(ss.NotConverged, match="too many steps"):
        rows.required()
    assert rows[:1].required().tolist() == [1.0]


def test_rows_of_a_kernel_are_translated_and_replaced():
    infinite = Column.of(np.array([np.inf, 2.0]), 0.0, WHY)
    assert (infinite.known.all(), infinite.errors.tolist()) == (True, [0, 0])
    values, codes = np.array([5.0, 6.0, 7.0]), np.array([10.0, 6.0, 7.0])
    rows = Column.of_codes(values, np.full(3, 0.5), codes, {6: WHY, 7: OTHER})
    assert [rows.at(i) for i in range(1)] == [5.0]
    assert (rows.at(1) is WHY, rows.at(2) is OTHER) == (True, True)
    assert rows.perhaps(above=1e300).tolist() == [False, True, True]
    new = column().replaced(np.array([False, True, True]), rows[1:])
    assert (new.at(0), new.at(1) is WHY, new.at(2) is OTHER) == (1.0, True, True)
    assert new.replaced(np.array([False, False, True]), rows[:1]).at(2) == 5.0
