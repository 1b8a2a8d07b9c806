"""`slope_average`: a criterion of any law as a fast function, closed form or not."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cached_property
from operator import le
from typing import Any, Literal, overload

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Condition, FloatArray, Mpf, Numbers, Substitution
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.numbers import DOUBLE_DIGITS, NEGLIGIBLE, binary_fraction, read_array
from stickslip_sym.core.precision import mp, own_mpf, rounded
from stickslip_sym.core.remedies import Argument, Call
from stickslip_sym.criteria.criterion import Criterion, CriterionName, find
from stickslip_sym.criteria.enclosure import enclose
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.evaluation.reference_average import MeanSlope
from stickslip_sym.formula.evaluation.term_function import CANCELLED, TermFunction, count_of
from stickslip_sym.formula.evaluation.term_sum import TermSum
from stickslip_sym.formula.exact import exact_value
from stickslip_sym.model.expression.letters import substitute_numbers
from stickslip_sym.model.expression.pieces import mean_slope_at_kinks
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.output import printing
from stickslip_sym.output.data import DataResult

OnInvalid = Literal["raise", "nan"]

_ELEMENTS_IN_CACHE = 16000
"""Elements: the arrays of a block stay in the cache, below 128 kB, from where each is a system call."""
_LARGEST_DOUBLE = float(np.finfo(np.float64).max)


@dataclass(frozen=True, eq=False)
class SlopeAverage(TermSum, DataResult, by_identity=True):
    """The damping coefficient of a criterion, c = -N <mu'(V(1 + s))>_w, as a function over arrays.

    Attributes
    ----------
    law : FrictionLaw
        Bound values become the defaults of a call.
    criterion : Criterion
    terms : tuple of Term
        Of the law: everything here is made from them.
    """

    @property
    def reported(self) -> tuple[str, ...]:
        """What a dictionary of it has; a closed form says more."""
        return ("law", "criterion")

    def _exactly(self, point: Substitution, digits: int) -> Mpf:
        """Return the value at exact arguments, by an enclosure of the definition."""
        if point[symbols.V] == 0 or self.criterion.weight is None:
            slope = self.law.slope_expr
            at_belt = mean_slope_at_kinks(slope).subs(symbols.v, symbols.V)
            return exact_value(-symbols.N * at_belt, slope, point, digits)
        law = self.law.bind(**{name: point[s] for name, s in self.arguments.items() if name not in ("V", "N")})
        if substitute_numbers(law.slope_expr, law.bound.point) == 0:  # at these values mu is constant
            return rounded(own_mpf(sp.Integer(0)), digits)
        enclosure = enclose(law, self.criterion, V=point[symbols.V], N=point[symbols.N], digits=digits)
        middle = enclosure.mid
        if enclosure.low * enclosure.high <= 0:  # 0, or what 400 digits leave open
            values = [float(point[symbol]) for symbol in self.arguments.values()]
            if not enclosure.radius <= Fraction(NEGLIGIBLE * float(self._unit(values)[0])):
                raise NotConverged(
                    f"the {self.criterion.name} criterion of {self.law.text} is not enclosed at "
                    f"V = {float(point[symbols.V]):g}: all that is known is {enclosure}"
                )
            middle = Fraction(0)
        with mp.workdps(digits):
            return rounded(own_mpf(sp.Rational(middle.numerator, middle.denominator)), digits)

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """Relations between the law's parameters without which the criterion has no value."""
        relations = [
            function.term.condition_in_parameters(condition)
            for function in self.functions
            for condition in function.average.conditions
        ]
        return tuple(dict.fromkeys(relation for relation in relations if relation != sp.true))

    def require(self, values: Mapping[str, Any]) -> None:
        """Refuse missing and unknown arguments, and values for which the criterion does not exist."""
        if values.keys() != self.arguments.keys():
            for name in values:
                if name not in self.arguments:
                    hint = suggestion(name, self.arguments)
                    known = ", ".join(self.arguments)
                    raise InputError(f"{name!r} is not an argument of this closed form{hint}; it takes: {known}")
            missing = [name for name in self.arguments if name not in values]
            examples = ", ".join(str(Argument(name)) for name in missing)
            raise InputError(f"no value for {', '.join(missing)}; give {examples}")
        if self.law.v_max is not None:
            speeds = np.ma.masked_invalid(np.ma.asarray(values["V"], dtype=np.float64))
            if speeds.count():
                self.law.require_speed(speeds.max() * (1 if self.criterion.weight is None else 2))
        for relation in self.conditions:
            if not isinstance(relation, sp.core.relational.Relational):
                raise InputError(
                    f"the {self.criterion.name} criterion has no value: mu grows without bound at v = 0+, and its "
                    "integral diverges; cut mu off there: write Max(v, v_c) for v"
                )
            names = sorted(map(str, relation.free_symbols))
            columns = [np.asarray(values[name], dtype=np.float64) for name in names]
            margin = function_of([self.arguments[name] for name in names], relation.gts - relation.lts, "numpy")
            if not np.all(margin(*columns) > 0):
                got = ", ".join(f"{name} = {values[name]}" for name in names)
                raise InputError(
                    f"the {self.criterion.name} criterion exists for {printing.text(relation)} only, got {got}; "
                    "for other values its integral diverges"
                )

    @overload
    def __call__(self, *, on_invalid: OnInvalid = "raise", **values: float) -> float: ...
    @overload
    def __call__(self, *, on_invalid: OnInvalid = "raise", **values: ArrayLike) -> FloatArray: ...
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
            In float64, with an error of a few units of eps N <|mu'|>; of the equilibrium criterion, which vanishes
            where mu' does, of eps N times the sum of the |terms| of mu'(V). At V = 0 the limit -N mu'(0+).
            A number has the same digits alone and in an array, as long as no shape of a profile, such as an
            exponent, is new.

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
        if numbers and all(map(le, self._lowest, ordered)) and max(ordered) <= _LARGEST_DOUBLE:
            return self._of_floats(list(map(float, ordered)))
        return self._over_arrays(ordered, on_invalid)

    @cached_property
    def _defaults(self) -> dict[str, ArrayLike]:
        return {name: float(value) for name, value in self.law.values.items() if name in self.arguments}

    @cached_property
    def _lowest(self) -> list[float]:
        """The lowest value that each argument may have."""
        return [0.0 if symbol.is_nonnegative else -_LARGEST_DOUBLE for symbol in self.arguments.values()]

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
        for start in range(0, flat_result.size, _ELEMENTS_IN_CACHE):
            block: Any = slice(start, start + _ELEMENTS_IN_CACHE)
            if good is not None:
                block = start + np.flatnonzero(good[block])
                if not block.size:
                    continue
            flat_result[block] = self._of_floats(
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

    # -- floats and flat arrays of one length --------------------------------------------------------

    def _of_floats(self, values: Sequence[Numbers]) -> Numbers:
        """Evaluate at floats, or at floats and flat arrays of one length.

        A value beyond the range of float64 is refused, and a speed for which the law is needed where it ends.
        """
        with np.errstate(all="ignore"):
            total = self._total(values)
        if isinstance(total, float):
            if math.isfinite(total):
                return total + 0.0
            return self._by_balls([float(value) for value in values])
        if not np.isfinite(total.sum()):  # one pass; what overflows there is looked at
            for i in np.flatnonzero(~np.isfinite(total)):
                total[i] = self._by_balls([v if isinstance(v, float) else float(v[i]) for v in values])
        total += 0.0  # -0.0 becomes 0.0
        return total

    def _total(self, values: Sequence[Numbers]) -> Numbers:
        """Add up the terms; NaN where they cancel, or one has no branches."""
        parts = [self._part(term, values) for term in self.functions]
        count = count_of(values)
        if not count:
            floats = [float(part) for part in parts]
            total = sum(floats, 0.0)
            sizes = sum(map(abs, floats), 0.0)
            kept = len(parts) < 2 or sizes <= CANCELLED * abs(total) or sizes <= self._unit(values)[0]
            return total if kept else math.nan
        result = np.array(np.broadcast_to(parts[0] if parts else 0.0, count))
        if len(parts) < 2:
            return result
        spread = np.abs(result)
        for part in parts[1:]:
            result += part
            spread += np.abs(part)
        here = np.flatnonzero(spread > CANCELLED * np.abs(result))
        if here.size:
            some = [value if isinstance(value, float) else value[here] for value in values]
            result[here[~(spread[here] <= self._unit(some))]] = np.nan
        return result

    @staticmethod
    def _part(term: TermFunction, values: Sequence[Numbers]) -> Numbers:
        try:
            return term(values)
        except ArithmeticError:  # of floats; arrays give infinity or NaN
            return math.nan

    @cached_property
    def _mean_slope(self) -> MeanSlope:
        mu = sp.Add(*[term.expr for term in self.terms])
        return MeanSlope(mu, self.criterion, list(self.arguments.values())[2:])

    def _unit(self, values: Sequence[Numbers]) -> FloatArray:
        """Return the size of terms that N <|mu'|> allows: where the slope itself cancels, they are larger."""
        speed, force, *rest = (np.atleast_1d(np.asarray(value, dtype=np.float64)) for value in values)
        unit = np.asarray(CANCELLED * force * self._mean_slope(speed, *rest))
        return np.where(np.isfinite(unit), unit, 0.0)  # what is beyond floats measures nothing

    def _by_balls(self, values: Sequence[float]) -> float:
        point = {symbol: binary_fraction(x) for symbol, x in zip(self.arguments.values(), values, strict=True)}
        for term in self.functions:
            term.require_reach(values)
        try:
            value = float(self._exactly(point, DOUBLE_DIGITS)) + 0.0
        except NotConverged:  # as where mu is infinite at v = 0; branches know its power there
            for term in self.functions:
                term.ask_for_branches(values)
            with np.errstate(all="ignore"):
                value = float(self._total(values)) + 0.0
            if math.isnan(value):
                raise
        if not math.isfinite(value):
            raise InputError(
                "the damping coefficient is beyond the range of float64; use ",
                Call("evaluate(digits=...)", "derive LAW"),
            )
        return value

    # -- what is made of it --------------------------------------------------------------------------

    def code(self, language: str) -> str:
        """Return text of a language that defines a function ``damping`` of V, N, ...

        The language is "c", "python", "octave" or "javascript". The text has the branches of a call, and gives
        NaN where a call refuses. Where terms cancel, a call turns to ball arithmetic, and the text adds them up
        as they are.

        Raises
        ------
        InputError
            If there is no such language, or a profile has a shape without a value: bind it first.
        """
        return writer.code({"damping": (self, self.described)}, language)

    @property
    def described(self) -> str:
        """What it is, and of which law, in lines for a comment."""
        return f"{self!r}\nmu(v) = {self.law.text}"

    def __getstate__(self) -> dict[str, object]:
        # What is compiled cannot be pickled, and is made again when it is needed.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.law.name or self.law.text}, {self.criterion.name}"


def _array(name: str, value: ArrayLike) -> FloatArray:
    if isinstance(value, np.ma.MaskedArray):
        # What is masked takes no part: 1 is a valid value of everything.
        value = value.filled(1) if value.dtype.kind in "iub" else value.filled(1.0)
    return read_array(name, value, finite=False).astype(np.float64, copy=False)


def slope_average(law: FrictionLaw | str, criterion: CriterionName | Criterion = "least_squares") -> SlopeAverage:
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
    law = as_law(law)
    return SlopeAverage(law, find(criterion), law.terms)
