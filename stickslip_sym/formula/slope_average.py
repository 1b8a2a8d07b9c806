"""`slope_average`: a criterion of any law as a fast function, closed form or not."""

import math
from collections.abc import Mapping
from functools import cached_property
from operator import le
from typing import Any, Literal

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray, Mpf, Numbers
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import read_array, suggestion, to_mpf
from stickslip_sym.criteria.criterion import Criterion, find
from stickslip_sym.criteria.enclosure import enclose
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.evaluation.evaluator import Evaluator, Exact
from stickslip_sym.formula.exact import exact_value
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.terms import Term
from stickslip_sym.output import printing

OnInvalid = Literal["raise", "nan"]

_BLOCK = 16000  # elements: the arrays of a block stay in the cache, below 128 kB, from where each is a system call
_DIGITS = 17  # of a value by balls
_LARGEST = float(np.finfo(np.float64).max)


class SlopeAverage:
    """The damping coefficient of a criterion, c = -N <mu'(V(1 + s))>_w, as a function over arrays.

    Parameters
    ----------
    law : FrictionLaw
        Bound values become the defaults of a call.
    criterion : Criterion
    exact : callable, optional
        The last resort, from the exact values of all arguments to the criterion; its enclosure if not given.
    terms : tuple of Term, optional
        Those of the law if not given.
    """

    def __init__(
        self,
        law: FrictionLaw,
        criterion: Criterion,
        exact: Exact | None = None,
        terms: tuple[Term, ...] | None = None,
    ) -> None:
        self.law, self.criterion, self._exact, self._terms = law, criterion, exact, terms
        used = law.expr.free_symbols
        parameters = {name: p.symbol for name, p in law.parameters.items() if p.symbol in used}
        self.arguments = {"V": symbols.V, "N": symbols.N, **parameters}
        self.evaluator = Evaluator(
            law.terms if terms is None else terms,
            criterion,
            list(self.arguments.values()),
            exact or self._by_definition,
        )
        self._defaults = {name: float(value) for name, value in law.values.items() if name in parameters}

    def _by_definition(self, point: Mapping[Expr, Expr]) -> Mpf:
        """Take the last resort: an enclosure of the definition."""
        if point[symbols.V] == 0 or self.criterion.weight is None:
            slope = self.law.slope_expr
            return exact_value(-symbols.N * slope.subs(symbols.v, symbols.V), slope, point, _DIGITS)
        law = self.law.bind(**{name: point[s] for name, s in self.arguments.items() if name not in ("V", "N")})
        middle = enclose(law, self.criterion, V=point[symbols.V], N=point[symbols.N], digits=_DIGITS).mid
        return to_mpf(sp.Rational(middle.numerator, middle.denominator))

    @cached_property
    def conditions(self) -> tuple[Expr, ...]:
        """Relations between the law's parameters without which the criterion has no value."""
        relations = [
            function.term.in_parameters(condition)
            for function in self.evaluator.terms
            for condition in function.average.conditions
        ]
        return tuple(dict.fromkeys(relation for relation in relations if relation != sp.true))

    def require(self, values: Mapping[str, Any]) -> None:
        """Refuse missing and unknown arguments, and values for which the criterion does not exist.

        Raises
        ------
        InputError
        """
        if values.keys() != self.arguments.keys():
            for name in values:
                if name not in self.arguments:
                    hint, known = suggestion(name, self.arguments), ", ".join(self.arguments)
                    raise InputError(f"{name!r} is not an argument of this closed form{hint}; it takes: {known}")
            missing = [name for name in self.arguments if name not in values]
            raise InputError(
                f"no value for {', '.join(missing)}; give {', '.join(f'{name}=...' for name in missing)}"
            )
        if self.law.v_max is not None:
            speeds = np.ma.masked_invalid(np.ma.asarray(values["V"], dtype=np.float64))
            if speeds.count():
                self.law.require_speed(speeds.max() * (1 if self.criterion.weight is None else 2))
        for relation in self.conditions:
            names = sorted(map(str, relation.free_symbols))
            columns = [np.asarray(values[name], dtype=np.float64) for name in names]
            margin = function_of([self.arguments[name] for name in names], relation.gts - relation.lts, "numpy")
            if not np.all(margin(*columns) > 0):
                got = ", ".join(f"{name} = {values[name]}" for name in names)
                raise InputError(
                    f"the {self.criterion.name} criterion exists for {printing.text(relation)} only, got {got}; "
                    "for other values its integral diverges"
                )

    def __call__(self, *, on_invalid: OnInvalid = "raise", **values: ArrayLike) -> Any:
        """Return the damping coefficient in kg/s, broadcast over all arguments.

        Parameters
        ----------
        on_invalid : {"raise", "nan"}
            What becomes of an argument that is negative or infinite. NaN and masked entries stay what they are.
        **values : float or array_like
            V (m/s), N (N) and the law's parameters; those that the law has bound may be left out.

        Returns
        -------
        float, numpy.ndarray or numpy.ma.MaskedArray
            In float64, with an error of a few units of eps N <|mu'|>; at V = 0 the limit -N mu'(0+). A number has
            the same digits alone and in an array, as long as no shape of a profile, such as an exponent, is new.

        Raises
        ------
        InputError
            For a missing, unknown, negative or infinite argument, a value for which the criterion does not exist,
            a speed for which the law is needed where it has no value, or a result beyond the range of float64.
        NotConverged
            If the slope is too irregular.
        """
        given = self._defaults | values
        self.require(given)
        if on_invalid not in ("raise", "nan"):
            raise InputError(f'on_invalid = {on_invalid!r} must be "raise" or "nan"')
        ordered: list[Any] = [given[name] for name in self.arguments]
        numbers = {float, int}.issuperset(map(type, ordered))
        if numbers and all(map(le, self._lowest, ordered)) and max(ordered) <= _LARGEST:
            return self.evaluator(list(map(float, ordered)))
        return self._over_arrays(ordered, on_invalid)

    @cached_property
    def _lowest(self) -> list[float]:
        """The lowest value that each argument may have."""
        return [0.0 if symbol.is_nonnegative else -_LARGEST for symbol in self.arguments.values()]

    def _over_arrays(self, values: list[ArrayLike], on_invalid: OnInvalid) -> Any:
        arrays = [_array(name, value) for name, value in zip(self.arguments, values, strict=True)]
        try:
            shape = np.broadcast_shapes(*(array.shape for array in arrays))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in zip(self.arguments, arrays, strict=True))
            raise InputError(f"the shapes do not broadcast: {shapes}") from None
        flat: list[Numbers] = [
            float(array.item()) if array.size == 1 else np.broadcast_to(array, shape).ravel() for array in arrays
        ]
        good = self._valid(arrays, shape, on_invalid)
        flat_result = np.full(math.prod(shape), np.nan)
        for start in range(0, flat_result.size, _BLOCK):
            block: Any = slice(start, start + _BLOCK)
            if good is not None:
                block = start + np.flatnonzero(good[block])
                if not block.size:
                    continue
            flat_result[block] = self.evaluator(
                [value if isinstance(value, float) else value[block] for value in flat]
            )
        result = flat_result.reshape(shape)
        masks = [np.ma.getmaskarray(value) for value in values if isinstance(value, np.ma.MaskedArray)]
        if masks:
            mask = np.logical_or.reduce([np.broadcast_to(mask, shape) for mask in masks])
            return np.ma.MaskedArray(result, mask)
        return float(result) if result.ndim == 0 else result

    def _valid(self, arrays: list[FloatArray], shape: tuple[int, ...], on_invalid: OnInvalid) -> BoolArray | None:
        """Return where all arguments are valid numbers; None if they are everywhere."""
        good: BoolArray | None = None
        for name, lowest, array in zip(self.arguments, self._lowest, arrays, strict=True):
            if not array.size or (array.min() >= lowest and array.max() < np.inf):
                continue
            invalid = (array < lowest) | np.isinf(array)
            if invalid.any() and on_invalid == "raise":
                first = array[invalid].flat[0]
                if np.isinf(first):
                    raise InputError(f"{name} holds a value that is not finite: {first}")
                raise InputError(f"{name} = {first:g} must not be negative")
            good = (np.ones(shape, dtype=bool) if good is None else good) & ~(invalid | np.isnan(array))
        return None if good is None else good.ravel()

    def code(self, language: str) -> str:
        """Return text of a language that defines a function ``damping`` of V, N, ...; see `ClosedForm.code`."""
        return writer.code({"damping": (self, repr(self))}, language)

    def __reduce__(self) -> tuple[object, ...]:
        return SlopeAverage, (self.law, self.criterion, self._exact, self._terms)

    def __repr__(self) -> str:
        return f"SlopeAverage: {self.law.name or self.law.text}, {self.criterion.name}"


def _array(name: str, value: ArrayLike) -> FloatArray:
    if isinstance(value, np.ma.MaskedArray):
        # What is masked takes no part: 1 is a valid value of everything.
        value = value.filled(1) if value.dtype.kind in "iub" else value.filled(1.0)
    return read_array(name, value, finite=False).astype(np.float64, copy=False)


def slope_average(law: FrictionLaw | str, criterion: str | Criterion = "least_squares") -> SlopeAverage:
    """Return a criterion of a law as a fast function; no closed form is needed.

    It is computed as a closed form's call is: each term of the law by branches in one dimensionless speed (series,
    closed form, table, tail), made once for a profile from values in ball arithmetic. Arrays go through in blocks
    that stay in the processor's cache. The error is a few units of eps N <|mu'|>.

    Parameters
    ----------
    law : FrictionLaw or str
        Kinks and all; bound values become the defaults of a call.
    criterion : str or Criterion
        "least_squares", "harmonic" or "equilibrium".

    Returns
    -------
    SlopeAverage

    Examples
    --------
    >>> damping = slope_average("0.2 + 0.3*exp(-(v/0.5)^1.5)")
    >>> f"{damping(V=0.5, N=9.81):.12g}"
    '2.97253721817'
    """
    return SlopeAverage(as_law(law), find(criterion))
