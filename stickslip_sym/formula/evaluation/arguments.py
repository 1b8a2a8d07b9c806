"""Arguments of a criterion as users give them, and calls in blocks that stay in the processor's cache."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray, Numbers
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_array, suggestion
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.products import extremes
from stickslip_sym.formula.evaluation.room import Room
from stickslip_sym.formula.evaluation.stable import StableFunction
from stickslip_sym.model.law import FrictionLaw

__all__ = ["OnInvalid", "call", "check_names", "check_reach"]

OnInvalid = Literal["raise", "nan"]

_BLOCK = 32000  # elements: the few arrays of 256 kB that a block takes stay in the cache


def check_names(arguments: Mapping[str, Expr], given: Mapping[str, ArrayLike]) -> None:
    """Refuse names that are not arguments, and arguments without a value.

    Raises
    ------
    InputError
    """
    if given.keys() == arguments.keys():
        return
    for name in given:
        if name not in arguments:
            known = ", ".join(arguments)
            hint = suggestion(name, arguments)
            raise InputError(f"{name!r} is not an argument of this closed form{hint}; it takes: {known}")
    missing = [name for name in arguments if name not in given]
    example = ", ".join(f"{name}=..." for name in missing)
    raise InputError(f"no value for {', '.join(missing)}; give {example}")


def check_reach(law: FrictionLaw, criterion: Criterion, V: ArrayLike) -> None:
    """Refuse belt speeds for which a criterion needs mu beyond the last speed that the law is known for.

    Raises
    ------
    InputError
    """
    if law.v_max is None:
        return
    speeds = np.ma.masked_invalid(np.ma.asarray(V, dtype=np.float64))
    if speeds.count():
        law.require_speed(speeds.max() * (1 if criterion.weight is None else 2))


def call(
    function: StableFunction, arguments: Mapping[str, Expr], given: Mapping[str, ArrayLike], on_invalid: OnInvalid
) -> Any:
    """Evaluate a criterion, broadcast over all arguments.

    Parameters
    ----------
    function : StableFunction
    arguments : mapping of str to Symbol
        In the function's order.
    given : mapping of str to array_like
        A value for each of them.
    on_invalid : {"raise", "nan"}
        What becomes of a negative or infinite argument.

    Returns
    -------
    float, numpy.ndarray or numpy.ma.MaskedArray
    """
    if on_invalid not in ("raise", "nan"):
        raise InputError(f'on_invalid = {on_invalid!r} must be "raise" or "nan"')
    values = [given[name] for name in arguments]
    if all(type(value) is float or (type(value) is int and value.bit_length() < 1000) for value in values):
        floats = [float(value) for value in values]  # type: ignore[arg-type]  # just looked
        if _is_valid(floats, arguments):
            return function.single(floats) + 0.0  # -0.0 becomes 0.0
    arrays = [_array(name, value) for name, value in zip(arguments, values, strict=True)]
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in zip(arguments, arrays, strict=True))
        raise InputError(f"the shapes do not broadcast: {shapes}") from None
    result = _in_blocks(function, arguments, arrays, shape, on_invalid)
    masks = [np.ma.getmaskarray(value) for value in values if isinstance(value, np.ma.MaskedArray)]
    if masks:
        mask = np.zeros(shape, dtype=bool)
        for part in masks:
            mask |= part
        return np.ma.MaskedArray(result, mask)
    return float(result) if result.ndim == 0 else result


def _is_valid(floats: list[float], arguments: Mapping[str, Expr]) -> bool:
    for value, symbol in zip(floats, arguments.values(), strict=True):
        if not (0 <= value < np.inf or (-np.inf < value < 0 and not symbol.is_nonnegative)):
            return False
    return True


def _array(name: str, value: ArrayLike) -> FloatArray:
    if isinstance(value, np.ma.MaskedArray):
        # What is masked takes no part: 1 is a valid value of everything.
        value = value.filled(1) if value.dtype.kind in "iub" else value.filled(1.0)
    return read_array(name, value, finite=False)


def _in_blocks(
    function: StableFunction,
    arguments: Mapping[str, Expr],
    arrays: list[FloatArray],
    shape: tuple[int, ...],
    on_invalid: OnInvalid,
) -> FloatArray:
    """Evaluate block by block; what has one element stays one number."""
    lowest = [0.0 if symbol.is_nonnegative else -np.finfo(np.float64).max for symbol in arguments.values()]
    names = list(arguments)
    single = [float(array.item()) if array.size == 1 else None for array in arrays]
    places = [i for i, value in enumerate(single) if value is None]
    result = np.empty(shape)
    for i, value in enumerate(single):
        if value is not None and _bad(value, names[i], lowest[i], on_invalid).any():
            result[...] = np.nan
            return result
    if not places:
        places, single[0] = [0], None
        arrays[0] = arrays[0].reshape((1,) * len(shape))
    varying = [arrays[i] for i in places]
    blocks: Any = np.nditer(  # type: ignore[call-overload]  # its stubs know no mixed lists
        [*varying, result],
        flags=["external_loop", "buffered", "zerosize_ok"],
        op_flags=[["readonly", "contig"]] * len(varying) + [["writeonly", "contig"]],
        op_dtypes=[np.float64] * (len(varying) + 1),
        casting="unsafe",
        order="K",
        buffersize=_BLOCK,
    )
    room, ends = Room(), [(0.0 if value is None else value,) * 2 for value in single]
    with blocks:
        for *columns, out in blocks:
            if not out.size:
                continue
            values: list[Any] = list(single)
            bad: BoolArray | bool = False
            for i, column in zip(places, columns, strict=True):
                values[i], ends[i] = column, extremes(column)
                if not (ends[i][0] >= lowest[i] and ends[i][1] < np.inf):
                    bad = bad | _bad(column, names[i], lowest[i], on_invalid)
            if bad is False:
                function.fill(values, ends, out, room)
                continue
            good = np.flatnonzero(~bad)
            out[...] = np.nan
            out[good] = function.array([v if isinstance(v, float) else v[good] for v in values])
    return result


def _bad(value: Numbers, name: str, lowest: float, on_invalid: OnInvalid) -> BoolArray:
    """Return where an argument is no number, or not a valid one."""
    column: FloatArray = np.asarray(value)
    invalid: BoolArray = (column < lowest) | np.isinf(column)
    if invalid.any() and on_invalid == "raise":
        first = column[invalid].flat[0]
        if np.isinf(first):
            raise InputError(f"{name} holds a value that is not finite: {first}")
        raise InputError(f"{name} = {first:g} must not be negative")
    return invalid | np.isnan(column)
