"""Numbers that carry a standard error, as users give them: text like "0.50+/-0.02", or `uncertainties.ufloat`.

The library `uncertainties` reads the text, and keeps which numbers are correlated.
"""

import math
import re
import warnings
from collections.abc import Mapping
from typing import Any

from uncertainties import UFloat as UFloat
from uncertainties import correlation_matrix, ufloat, ufloat_fromstr
from uncertainties.core import NegativeStdDev

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import SAME
from stickslip_sym.core.units import si_number

_WITH_ERROR = re.compile(r"\+/?-|±|\(")
_CORRELATION_DIGITS = -round(math.log10(SAME))  # of correlations that count as equal: files keep them to rounding
_EXAMPLES = "write it like 0.50+/-0.02 or 0.50(2)"


def split(value: Any, name: str) -> tuple[Any, UFloat | None]:
    """Return a number without its standard error, and with it; None where it has none.

    Text with "+/-", "+-", "±" or brackets is read; its number is the decimal that it says. `name` is for messages.
    """
    number: Any
    value = si_number(value, name)
    if isinstance(value, UFloat):
        read = value
        number = value.nominal_value
    elif isinstance(value, str) and _WITH_ERROR.search(value):
        read = _read_uncertain(value, name)
        number = repr(read.nominal_value)
    else:
        return value, None
    if not (math.isfinite(read.nominal_value) and math.isfinite(read.std_dev)):
        raise InputError(f"{name} = {str(value)[:60]!r} is not finite; {_EXAMPLES}")
    return number, read if read.std_dev > 0 else None


def _read_uncertain(text: str, name: str) -> UFloat:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of a standard error that is 0, which is none here
            return ufloat_fromstr(text.replace("+-", "+/-"))
    except NegativeStdDev:
        raise InputError(f"{name} = {text[:60]!r} has a negative standard error; {_EXAMPLES}") from None
    except (ValueError, OverflowError):
        raise InputError(f"{name} = {text[:60]!r} is not a number with a standard error; {_EXAMPLES}") from None


def separated(values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, UFloat]]:
    """Return numbers by name without their standard errors, and those that have one with it."""
    pairs = {name: split(value, name) for name, value in values.items()}
    numbers = {name: number for name, (number, _) in pairs.items()}
    return numbers, {name: read for name, (_, read) in pairs.items() if read is not None}


def spread(values: Mapping[str, UFloat]) -> tuple[object, ...]:
    """Return the names of numbers that carry a standard error, these errors, and the correlations, rounded."""
    if not values:
        return ()
    names = sorted(values)
    correlations = correlation_matrix([values[name] for name in names]).round(_CORRELATION_DIGITS)
    return tuple(names), tuple(values[name].std_dev for name in names), tuple(correlations.ravel().tolist())


def text_with_error(value: float, error: float) -> str:
    """Return a number with its standard error as text, to two digits of that."""
    if not error > 0 or not math.isfinite(error):
        return f"{value:.10g} +/- {error:g}"
    return f"{ufloat(value, error):.2u}".replace("+/-", " +/- ")


def interval_text(low: float, high: float) -> str:
    """Return an interval as text, with so many digits that its ends differ by two."""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        if low == high:
            return f"{low:.4g}"
        return f"{low:.4g} to {high:.4g}"
    digits = max(4, min(17, math.ceil(math.log10(max(abs(low), abs(high)) / (high - low))) + 2))
    return f"{low:.{digits}g} to {high:.{digits}g}"
