"""The average F(r) = -<g'(r(1 + s))>_w of a profile g(x), to some twenty digits more than a float has.

From the closed form in ball arithmetic where there is one, else by a Gauss rule in the same arithmetic. Its
panels double from x = 0, so that all scales are met, and halve until the slope is resolved in each; what they hold
below x = r is computed once for all r. Beside it: the mean size of the slope, and the speed at which a profile
ends.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp
from flint import acb, arb, arb_poly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.balls import BallFunction, ball_function, ball_value, rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import without_squares
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.expression.pieces import branch_from, jumps, places

BITS = 110
"""The working precision of values."""

_ENOUGH = 70  # bits of relative accuracy that a value of the closed form needs
_PLACES = (0.3, 0.6, 0.9, 2.2, 17.0)  # r at which a closed form is checked, over 1 or the largest one
_SAME = 2.0**-40  # by which it agrees

_NODES = 22  # in a panel
_RESOLVED = 2.0**-31  # of the slope in a panel: its last two Legendre coefficients; the rule has twice the order
_NEGLIGIBLE = 2.0**-72  # of the moment of |g'|: a panel that need not be resolved
_NOISE = 8  # times the radius of a ball around the slope: where the slope cancels no panel is resolved better
_HALVINGS = 10  # of a panel
_EXPANDED, _EXPANSION = 2, 28  # a weight that is no polynomial is expanded this many octaves below r; its terms
_CLOSE = 5  # octaves from r to the innermost panel, at least
_DEEPEST = -40  # octaves below that of the lowest kink, or below 1, where the innermost panel is looked for
_LARGEST_ORDER = 16

Samples = list[tuple[arb, arb]]
"""Places x, and g'(x) dx there."""
Map = Callable[[arb], tuple[arb, arb]]
"""From a variable u to x and dx/du."""


@dataclass(frozen=True)
class _Panel:
    """Samples up to an end, the moment of all below it, and what they add to an average in powers of end/r."""

    samples: Samples
    end: arb
    moment: arb
    average: arb_poly


class Unresolved(ArithmeticError):
    """No number of panels gives the values of an average: its profile waves for ever."""


class Values:
    """F(r) as a function of balls. Call it with the working precision `BITS`.

    Parameters
    ----------
    profile : sympy.Expr
        g in the symbol v, and in shapes.
    criterion : Criterion
    closed : sympy.Expr or None
        F in the symbol V; forgotten where it is not the average by the Gauss rule too, at a few places.
    point : mapping
        Values of the shapes in them.

    Raises
    ------
    InputError
        For a function that has no balls.
    """

    def __init__(
        self, profile: Expr, criterion: Criterion, closed: Expr | None, point: Mapping[Expr, Expr]
    ) -> None:
        self.profile, self.criterion, self.point = profile, criterion, point
        self.kinks = sorted((end for end in _reals(places(profile), point) if bool(end > 0)), key=float)
        inner = [sp.Rational(float(low + high) / 2) for low, high in pairwise([arb(0), *self.kinks])]
        outer = sp.Rational(float(2 * self.kinks[-1])) if self.kinks else sp.Integer(1)
        pieces = [branch_from(profile, point, place) for place in (*inner, outer)]
        self.last_piece = pieces[-1]
        self._slopes = [ball_function(slope_of(piece), symbols.v, point) for piece in pieces]
        self._jumps = [_reals(jump, point) for jump in jumps(profile)]
        mean_slope, shapes = MeanSlope(profile, criterion, list(point)), [float(value) for value in point.values()]
        self.mean_slope: Callable[[FloatArray], FloatArray] = lambda r: mean_slope(r, *shapes)
        self.reach = reach_of(profile, point)
        # In the innermost panel x is this power of the variable, for the slope may be a power of x.
        exponents = [node.exp.xreplace(dict(point)) for node in profile.atoms(sp.Pow) if node.base.has(symbols.v)]
        order = 2 * math.lcm(*(int(e.q) if e.is_Rational else _LARGEST_ORDER for e in exponents))
        self._order = min(order, _LARGEST_ORDER)
        self._panels: dict[tuple[bool, int], _Panel] = {}
        self._close = max(_CLOSE, self._order)
        highest = min([-self._close, *(math.frexp(float(kink))[1] - 1 for kink in self.kinks)])
        tried = range(highest, highest + _DEEPEST, -_CLOSE)
        self._first = next((octave for octave in tried if self._is_innermost(octave)), tried[-1])
        self._formula: BallFunction | None = None
        if closed is not None:
            with suppress(InputError):  # a special function that has no balls; the rule has no need of it
                self._formula = ball_function(closed, symbols.V, point)
        for share in _PLACES:
            r = arb(share * min(self.reach / 40, 1.0))
            value = self._by_formula(r)
            if value is not None and not bool(abs(value - self._by_rule(r)) <= _SAME * abs(value)):
                self._formula = None

    def __call__(self, r: arb) -> arb:
        """Return F(r).

        Raises
        ------
        Unresolved
        """
        value = self._by_formula(r)
        return self._by_rule(r) if value is None else value

    def _by_formula(self, r: arb) -> arb | None:
        """Return the closed form's value; None where it cancels."""
        if self._formula is None:
            return None
        try:
            whole = self._formula(acb(r), False)
        except (ValueError, ZeroDivisionError):
            return None
        known = whole.is_finite() and whole.imag.contains(0) and whole.real.rel_accuracy_bits() >= _ENOUGH
        return whole.real if known else None

    def _by_rule(self, r: arb) -> arb:
        if self.criterion.weight is None:
            return -self._slope(r)(acb(r), False).real
        last = math.frexp(float(r))[1] - 1  # the octave of r
        first = min(last - self._close, self._first)
        panels = [self._panel(True, first, arb(0))]
        for octave in range(first, last):
            panels.append(self._panel(False, octave, panels[-1].moment))
        moment = panels[-1].moment
        samples = self._between(_itself, arb(2) ** last, r, self._inside(arb(2) ** last, r), moment)
        # A weight may end like a square root: x = r (2 - u^2).
        roots = [(2 - kink / r).sqrt() for kink in reversed(self._inside(r, 2 * r))]
        samples += self._between(lambda u: (r * (2 - u * u), 2 * r * u), arb(0), arb(1), roots, moment)
        far = len(panels) if self.criterion.is_polynomial else max(len(panels) - _EXPANDED, 0)
        samples += [pair for panel in panels[far:] for pair in panel.samples]
        weight = _weight(self.criterion)
        total = sum((product * weight(x / r) for x, product in samples), arb(0))
        for panel in panels[:far]:
            p = panel.end / r
            total += panel.average(p) * (arb(1) if self.criterion.is_polynomial else p.sqrt())
        for place, height in self._jumps:
            if bool(place > 0) and bool(place < 2 * r):
                total += height * weight(place / r)
        return -total / r

    def _slope(self, x: arb) -> BallFunction:
        return self._slopes[sum(1 for kink in self.kinks if bool(kink < x))]

    def _inside(self, low: arb, high: arb) -> list[arb]:
        return [kink for kink in self.kinks if bool(kink > low) and bool(kink < high)]

    def _panel(self, innermost: bool, octave: int, moment: arb) -> "_Panel":
        """Return the panel up to 2^octave, or from there to twice that."""
        key = innermost, octave
        if key not in self._panels:
            low = arb(2) ** octave
            if innermost:
                samples, end = self._innermost(octave, None), low
            else:
                samples, end = self._between(_itself, low, 2 * low, self._inside(low, 2 * low), moment), 2 * low
            coefficients, powers = [], [product for _, product in samples]
            if not self.criterion.is_polynomial:
                powers = [product * (x / end).sqrt() for x, product in samples]
            for c in _in_powers(self.criterion):
                coefficients.append(c * sum(powers, arb(0)))
                powers = [power * x / end for power, (x, _) in zip(powers, samples, strict=True)]
            average = arb_poly(coefficients)
            self._panels[key] = _Panel(samples, end, moment + self._moment(samples), average)
        return self._panels[key]

    def _innermost(self, octave: int, halvings: int | None) -> Samples:
        end, order = arb(2) ** octave, self._order
        place: Map = lambda u: (end * u**order, order * end * u ** (order - 1))  # noqa: E731
        return self._samples(place, arb(0), arb(1), arb(0), halvings)

    def _is_innermost(self, octave: int) -> bool:
        """Return whether the slope is resolved by one panel from 0 to 2^octave."""
        try:
            return bool(self._innermost(octave, 0))
        except Unresolved:
            return False

    def _moment(self, samples: Samples) -> arb:
        """Return what |g'| contributes to an average over all that is larger."""
        power = max(1, math.ceil(self.criterion.order_at_rest))
        return sum((x**power * abs(product) for x, product in samples), arb(0))

    def _between(self, place: Map, low: arb, high: arb, inside: Sequence[arb], moment: arb) -> Samples:
        panels = pairwise([low, *inside, high])
        return [pair for panel in panels for pair in self._samples(place, *panel, moment, _HALVINGS)]

    def _samples(self, place: Map, low: arb, high: arb, moment: arb, halvings: int | None) -> Samples:
        """Return samples in a panel of u, or in its halves where the slope is not resolved; None for none.

        Raises
        ------
        Unresolved
        """
        if not bool(low < high):
            return []
        half, (nodes, last) = (high - low) / 2, _legendre(BITS)
        slope = self._slope(place(low + half)[0])
        samples, heights, noise = [], [], 0.0
        for t, weight in nodes:
            x, rate = place(low + (1 + t) * half)
            ball = slope(acb(x), False).real * rate
            height = arb(0) if ball.contains(0) else ball.mid()  # a constant that cancels leaves a ball
            heights.append(float(height))
            noise = max(noise, float(ball.rad()))
            samples.append((x.mid(), height * weight * half))
        rest = np.abs(last @ heights).max()
        if halvings is None or rest <= _RESOLVED * max(map(abs, heights)) + _NOISE * noise:
            return samples
        if bool(self._moment(samples) <= _NEGLIGIBLE * moment):
            return samples
        if halvings == 0:
            raise Unresolved(f"{self.profile} is not resolved at v = {float(samples[0][0]):g}")
        parts = ((low, low + half), (low + half, high))
        return [pair for part in parts for pair in self._samples(place, *part, moment, halvings - 1)]


def _reals(exprs: Iterable[Expr], point: Mapping[Expr, Expr]) -> list[arb]:
    return [ball_value(expr, point).real for expr in exprs]


def _itself(x: arb) -> tuple[arb, arb]:
    return x, arb(1)


@lru_cache(maxsize=4)
def _legendre(bits: int) -> tuple[list[tuple[arb, arb]], FloatArray]:
    """Return nodes with their weights, and the matrix from values there to the last two Legendre coefficients."""
    del bits  # they are those of the working precision
    rule = [arb.legendre_p_root(_NODES, k, weight=True) for k in range(_NODES)]
    last = [[(n + 0.5) * float(weight * x.legendre_p(n)) for x, weight in rule] for n in (_NODES - 2, _NODES - 1)]
    return [(x.mid(), weight.mid()) for x, weight in rule], np.array(last)


def _weight(criterion: Criterion) -> Callable[[arb], arb]:
    """Return w(s) as a function of p = 1 + s."""
    if criterion.is_polynomial:
        return _in_powers(criterion)
    square = 4 / arb.pi() ** 2
    return lambda p: (square * p * (2 - p)).sqrt()


@lru_cache(maxsize=16)
def _in_powers(criterion: Criterion) -> arb_poly:
    """Return the weight in powers of p = 1 + s; one that is no polynomial over sqrt(p), for small p."""
    if criterion.is_polynomial:
        return arb_poly([arb(rational(c)) for c in reversed(criterion.from_rest.all_coeffs())])
    return arb_poly([2 / arb.pi() * arb(2).sqrt() * arb(rational(sp.binomial(sp.S.Half, k) / (-2) ** k))
                     for k in range(_EXPANSION)])  # fmt: skip


def slope_of(profile: Expr) -> Expr:
    """Return g', with sech(a)^2 for 1 - tanh(a)^2, which cancels."""
    return without_squares(sp.diff(profile, symbols.v))


# -- in floats -----------------------------------------------------------------------------------------


class MeanSlope:
    """<|g'|> of a profile to a few per cent, the unit in which errors of F are measured.

    Call it with an array of r, and of each parameter.
    """

    _LEVELS, _POINTS = 70, 6  # panels towards x = 0, nodes in each

    def __init__(self, profile: Expr, criterion: Criterion, parameters: Sequence[Expr]) -> None:
        slope, self._local = slope_of(profile), criterion.weight is None
        functions = [slope]
        if self._local:
            # At one point the rounding of r itself counts.
            self._p, self._w = np.ones(1), np.ones(1)
            functions.append(symbols.v * sp.diff(slope, symbols.v))
        else:
            x, w = np.polynomial.legendre.leggauss(self._POINTS)
            scale = 2.0 ** -np.arange(self._LEVELS)[:, None]
            self._p, self._w = (scale * (x + 3) / 2).ravel(), (scale * w / 2).ravel()
            self._w *= np.abs(
                np.polyval(np.array(criterion.from_rest.all_coeffs(), dtype=float), self._p)
                if criterion.is_polynomial
                else 2 / np.pi * np.sqrt(self._p * (2 - self._p))
            )
        self._functions: list[Callable[..., FloatArray]] = [
            function_of([symbols.v, *parameters], function, "numpy") for function in functions
        ]

    def __call__(self, r: FloatArray, *parameters: float | FloatArray) -> FloatArray:
        """Return <|g'|> at each r."""
        columns = [np.asarray(parameter)[..., None] for parameter in parameters]
        x = r[:, None] * self._p
        with np.errstate(all="ignore"):
            sizes = [
                np.nansum(np.broadcast_to(np.abs(function(x, *columns)), x.shape) * self._w, axis=1)
                for function in self._functions
            ]
        return np.asarray(np.max(sizes, axis=0))


_GRID = 2.0 ** np.arange(-30, 40, 1 / 16)  # where an argument is looked at for a change of its sign


def reach_of(profile: Expr, point: Mapping[Expr, Expr]) -> float:
    """Return the speed at which a profile ends: at a pole, or where a logarithm or a root has no real value.

    Infinity where there is none up to 2^40.
    """
    arguments = {node.args[0] for node in profile.atoms(sp.log)}
    arguments |= {
        node.base
        for node in profile.atoms(sp.Pow)
        if node.base != symbols.v and not (node.exp.is_Integer and node.exp.is_positive)
    }
    shapes = [float(value) for value in point.values()]
    return min((_first_zero(a, list(point), shapes) for a in arguments if a.has(symbols.v)), default=np.inf)


def _first_zero(expr: Expr, parameters: list[Expr], values: list[float]) -> float:
    """Return the lowest speed at which a function of v changes its sign, or infinity."""
    if expr.is_positive:
        return np.inf
    function = function_of([symbols.v, *parameters], expr, "numpy")
    with np.errstate(all="ignore"):
        signs = np.sign(np.broadcast_to(function(_GRID, *values), _GRID.shape))
    changes = np.flatnonzero(signs[1:] * signs[:-1] <= 0)
    if not changes.size:
        return np.inf
    low, high = _GRID[changes[0]], _GRID[changes[0] + 1]
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if np.sign(function(middle, *values)) == signs[changes[0]] else (low, middle)
    return float(low)
