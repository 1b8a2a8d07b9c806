"""When two results are equal: arrays are compared as a whole, NaN is NaN, and so on every version of Python."""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from numbers import Real
from typing import Any

import numpy as np


def say_the_same(result: Any, other: object) -> Any:
    """Whether two results of one class agree in every field that takes part in comparisons."""
    if type(other) is not type(result) or not is_dataclass(result):
        return NotImplemented
    compared = [each.name for each in fields(result) if each.compare]
    return all(_is_same(getattr(result, name), getattr(other, name)) for name in compared)


def _is_same(one: Any, other: Any) -> bool:
    """Whether two values of a field say the same: NaN is NaN, and what is not known has the same reason."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return _are_same_arrays(one, other)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_is_same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    if isinstance(one, Real) and isinstance(other, Real):
        return bool(one == other) or (math.isnan(one) and math.isnan(other))
    if type(one) is not type(other):
        return False
    if is_dataclass(one) and _is_compared_by_fields(one):
        return bool(say_the_same(one, other))
    return bool(one == other)


def _is_compared_by_fields(value: Any) -> bool:
    return bool(value.__dataclass_params__.eq)


def _are_same_arrays(one: Any, other: Any) -> bool:
    first = np.asarray(one)
    second = np.asarray(other)
    if first.shape != second.shape or first.dtype != second.dtype:
        return False
    return all(map(_is_same, first.ravel().tolist(), second.ravel().tolist()))
