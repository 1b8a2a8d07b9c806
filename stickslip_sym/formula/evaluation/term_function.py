"""A term of a law under a criterion, over floats and arrays: N amplitude/scale F(V/scale), F by its branches.

The powers of the arguments stand before the branches, so that nothing over- or underflows on the way.
"""

import math
from collections.abc import Callable, Sequence
from functools import reduce
from operator import mul

import numpy as np
import sympy as sp
from flint import arb

from stickslip_sym.core.aliases import BoolArray, Expr, Numbers
from stickslip_sym.core.errors import InputError, NoClosedForm
from stickslip_sym.core.lambdify import function_of, power_of
from stickslip_sym.core.numbers import LARGEST, binary_fraction
from stickslip_sym.core.precision import working_precision
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.average import average_of_profile
from stickslip_sym.formula.evaluation.branch_builder import branches_of
from stickslip_sym.formula.evaluation.branches import Branches, alike
from stickslip_sym.formula.evaluation.reference_average import BITS, reach_of
from stickslip_sym.model.terms import Term
from stickslip_sym.numerics.known import Unknown

CANCELLED = 4.0
"""The sum of the sizes of terms over the size of their sum, from where that may have lost digits."""
_WORTH_BRANCHES = 8  # values with the same shapes, from where their branches are made


def _accurate_factors(expr: Expr) -> tuple[float, dict[Expr, float]]:
    """Write a product as a number times powers of what is accurate in floats: arguments, and sums of them."""
    number: Expr = sp.Integer(1)
    powers: dict[Expr, float] = {}
    for base, exponent in sp.factor(expr).as_powers_dict().items():
        if base.is_number and exponent.is_number:
            number *= base**exponent
        else:
            base, power = (base, exponent) if exponent.is_Rational else (base**exponent, sp.Integer(1))
            powers[base] = powers.get(base, 0.0) + float(power)
    return float(number), powers


def _function_of_base(expr: Expr, arguments: Sequence[Expr]) -> Callable[[Sequence[Numbers]], Numbers]:
    """Return a factor of a product as a function of all arguments: NaN where it cancels."""
    if expr in arguments:
        index = list(arguments).index(expr)
        return lambda values: values[index]
    terms = sp.Add.make_args(expr)
    exact = all(term.is_Symbol or (-term).is_Symbol for term in terms) and len(terms) == 2
    one_sign = all(term.is_positive for term in terms) or all(term.is_negative for term in terms)
    if exact or one_sign or len(terms) == 1:
        size = sp.S.Zero
    else:
        size = sp.Add(*[abs(term) for term in terms])
    function = alike(function_of(arguments, [expr, size], "numpy"), sp.Tuple(expr, size))

    def base(values: Sequence[Numbers]) -> Numbers:
        value, spread = function(*values)
        if isinstance(value, float):
            if abs(value) * CANCELLED >= spread:
                return float(value)
            return math.nan
        return np.where(np.abs(value) * CANCELLED >= spread, value, np.nan)

    return base


class TermFunction:
    """A term of a law under a criterion, as a function of V, N and the parameters.

    It is number N prod bases^amplitude F(V/size prod bases^ratio); the arguments are V, N, then the parameters, in
    the order in which values come.
    """

    def __init__(self, term: Term, criterion: Criterion, arguments: Sequence[Expr]) -> None:
        self.term = term
        self.average = average_of_profile(term.profile, criterion)
        self.number, amplitude = _accurate_factors(term.amplitude / term.scale)
        self.size, scale = _accurate_factors(term.scale)
        self.bases = list(dict.fromkeys([*amplitude, *scale]))
        self.amplitude = [amplitude.get(base, 0.0) for base in self.bases]
        self.ratio = [-scale.get(base, 0.0) for base in self.bases]
        self._base_functions = [_function_of_base(base, arguments) for base in self.bases]
        self._shapes = [function_of(arguments, meaning, "numpy") for meaning in term.shapes.values()]
        self._asked: dict[tuple[float, ...], int] = {}
        self._branches: dict[tuple[float, ...], tuple[Branches, float] | Unknown] = {}

    def shape_values(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the values of the shapes at some values of the arguments."""
        return tuple(float(shape(*values)) for shape in self._shapes)

    def exact_shapes(self, shapes: Sequence[float]) -> dict[Expr, Expr]:
        """Return the symbols of the shapes with values as rationals."""
        return dict(zip(self.average.shapes, map(binary_fraction, shapes), strict=True))

    def branches(self, shapes: tuple[float, ...] = ()) -> Branches | Unknown:
        """Return the branches for values of the shapes, or why there are none."""
        average = self.average
        try:
            average.require_integrable()
        except NoClosedForm as error:  # a call refuses it, or another term cancels what is infinite
            return Unknown(*error.args)
        closed = None if average.profile.has(sp.Piecewise) else average.closed  # of many pieces it takes long
        return branches_of(average.profile, average.criterion, closed, tuple(self.exact_shapes(shapes).items()))

    def ask_for_branches(self, values: Sequence[float]) -> None:
        """Have branches made for the shapes at some values of the arguments, however few values they are for."""
        self._asked[self.shape_values(values)] = _WORTH_BRANCHES

    def require_reach(self, values: Sequence[float]) -> None:
        """Refuse a belt speed for which the law is needed beyond a pole, or the end of a logarithm or a root."""
        if self.average.criterion.weight is None:
            return
        bases = zip(self._base_functions, self.ratio, strict=True)
        try:
            reach = reach_of(self.average.profile, self.exact_shapes(self.shape_values(values)))
            factor = math.prod([float(power_of(base(values), e)) for base, e in bases if e]) / self.size
        except ArithmeticError:
            return  # a scale or a shape has no value, where the law itself may have one
        if values[0] * factor >= reach / 2 and reach < math.inf:
            raise InputError(
                f"V = {values[0]:g} m/s needs mu up to v = {2 * values[0]:g} m/s, but the term "
                f"{self.term.expr} of the law ends at v = {reach / factor:g} m/s"
            )

    def __call__(self, values: Sequence[Numbers]) -> Numbers:
        """Evaluate at floats, or at floats and flat arrays of one length; NaN where balls must be asked."""
        shapes = [shape(*values) for shape in self._shapes]
        if all(np.ndim(shape) == 0 for shape in shapes):
            return self._with_shapes(values, tuple(float(shape) for shape in shapes))
        count = count_of(values)
        kinds, which = np.unique([np.broadcast_to(shape, count) for shape in shapes], axis=1, return_inverse=True)
        result = np.full(count, np.nan)
        for kind, kind_shapes in enumerate(kinds.T.tolist()):
            here = np.flatnonzero(which.ravel() == kind)
            some = [value if isinstance(value, float) else value[here] for value in values]
            result[here] = self._with_shapes(some, tuple(kind_shapes))
        return result

    def _with_shapes(self, values: Sequence[Numbers], shapes: tuple[float, ...]) -> Numbers:
        count = count_of(values)
        if shapes not in self._branches:
            self._asked[shapes] = asked = self._asked.get(shapes, 0) + max(count, 1)
            if shapes and asked < _WORTH_BRANCHES:
                return math.nan
            self._branches[shapes] = self._with_largest(self.branches(shapes))
        made = self._branches[shapes]
        if isinstance(made, Unknown):
            return math.nan
        branches, largest = made
        factors = [values[0], values[1], *[base(values) for base in self._base_functions]]
        unsafe = _where_outside_range(factors, largest)
        if unsafe is False:
            return self._plain(branches, *factors)
        if not count:
            return self._apart(branches, *map(float, factors))
        arrays = [np.broadcast_to(np.asarray(factor), count) for factor in factors]
        result = np.array(self._plain(branches, *arrays))
        for i in np.flatnonzero(np.broadcast_to(unsafe, count)):
            result[i] = self._apart(branches, *(float(array[i]) for array in arrays))
        return result

    def _with_largest(self, branches: Branches | Unknown) -> tuple[Branches, float] | Unknown:
        """Add the size that V, N and the bases may have so that no product of their powers overflows."""
        if isinstance(branches, Unknown):
            return branches
        total = 2.0 + branches.steepest + sum(map(abs, self.amplitude))
        total += (1 + branches.steepest) * sum(map(abs, self.ratio))
        return branches, float(LARGEST ** (1 / total))

    def _plain(self, branches: Branches, speed: Numbers, force: Numbers, *bases: Numbers) -> Numbers:
        """Multiply, always in the same order."""
        factor: Numbers = 1 / self.size
        amplitude: Numbers = self.number
        for base, a, e in zip(bases, self.amplitude, self.ratio, strict=True):
            if e:
                factor = factor * power_of(base, e)
            if a:
                amplitude = amplitude * power_of(base, a)
        return branches(speed * factor) * (amplitude * force)

    def _apart(self, branches: Branches, speed: float, force: float, *bases: float) -> float:
        """Multiply in balls, whose exponents have no range to leave; NaN where 0 is raised to a negative power."""
        with working_precision(BITS):
            numbers = [arb(base) for base in bases]
            r = reduce(mul, map(pow, numbers, map(arb, self.ratio)), arb(speed) / arb(self.size))
            if not r.is_finite():
                return math.nan
            branch = branches.at(float(r))
            start = arb(float(branch(float(r)))) * r ** arb(branch.power) * arb(self.number) * arb(force)
            return float(reduce(mul, map(pow, numbers, map(arb, self.amplitude)), start))


def count_of(values: Sequence[Numbers]) -> int:
    """Return the length of the arrays among some values; 0 where all are floats."""
    for value in values:
        if not isinstance(value, float):
            return value.size
    return 0


def _where_outside_range(values: Sequence[Numbers], largest: float) -> BoolArray | bool:
    """Return where the size of a value is not between 1/largest and largest: everywhere, nowhere, or where."""
    smallest = 1 / largest
    result: BoolArray | bool = False
    for value in values:
        if isinstance(value, float):
            result = result | (not smallest < abs(value) < largest)
        elif not (value.min() > smallest and value.max() < largest):  # as it nearly always is
            outside = ~((np.abs(value) > smallest) & (np.abs(value) < largest))
            if outside.any():
                result = result | outside
    return result
