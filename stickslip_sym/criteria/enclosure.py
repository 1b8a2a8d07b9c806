"""`enclose`: a criterion between two exact numbers, by integration in ball arithmetic.

Arb bounds every error of its Gauss rules and of its roundings, so what comes out holds the value for certain; how
close the two ends are is what the working precision makes of it.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import MAX_EMAX, MIN_EMIN, ROUND_DOWN, Context, Decimal, localcontext
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from operator import add

import sympy as sp
from flint import acb, arb, ctx

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational, Substitution
from stickslip_sym.core.balls import BallFunction, Point, ball, ball_function, ball_value, integrated
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import Number, fraction
from stickslip_sym.core.precision import GUARD_BITS, refined, working_precision
from stickslip_sym.criteria.criterion import Criterion, CriterionName
from stickslip_sym.criteria.decay import bound_below, start_of, vanishing
from stickslip_sym.criteria.quadrature import MOST_DIGITS, MOST_DIGITS_LOST, read_operating_point
from stickslip_sym.model.expression.pieces import branch_from, kinks_at
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.taylor_model import balls_from_rest
from stickslip_sym.output.data import DataResult

_BITS_PER_DIGIT = math.log2(10)  # per digit
_MOST_BITS_LOST = math.ceil(MOST_DIGITS_LOST * _BITS_PER_DIGIT) + GUARD_BITS  # that are followed
_EXTREME = 100_000  # bits, beyond which an end is rounded outwards instead of written in full
_DIGITS_WITHOUT_CERTAINTY = 3  # digits of an end of an enclosure without a certain digit
_BITS_FINER_THAN_RADIUS = 4  # bits, by which ends of an enclosure are finer than its radius
_MOST_END_DIGITS = 50  # digits of an end, at most


@dataclass(frozen=True)
class Enclosure(DataResult):
    """Two numbers with the true value between them.

    Attributes
    ----------
    low, high : fractions.Fraction
        Exact.
    """

    low: Fraction
    high: Fraction

    @classmethod
    def of(cls, low: Number, high: Number) -> "Enclosure":
        """Return the enclosure between two numbers as users give them, exactly."""
        return cls(fraction(low, "end"), fraction(high, "end"))

    @property
    def mid(self) -> Fraction:
        """The number half-way."""
        return (self.low + self.high) / 2

    @property
    def radius(self) -> Fraction:
        """Half the width: what `mid` is off by, at most."""
        return (self.high - self.low) / 2

    @property
    def digits(self) -> int:
        """The digits of `mid` that are certain: -log10 of the relative radius, rounded down; 0 around zero."""
        if self.radius == 0:
            return MOST_DIGITS
        ratio = abs(self.mid) / self.radius
        bits = ratio.numerator.bit_length() - ratio.denominator.bit_length()
        certain = max(
            0, int((bits - 1) / _BITS_PER_DIGIT)
        )  # as text, an integer of thousands of digits costs too much
        return certain + (ratio >= Fraction(10) ** (certain + 1))

    def overlaps(self, other: "Enclosure") -> bool:
        """Whether one number may lie in both."""
        return self.low <= other.high and other.low <= self.high

    def apart(self, other: "Enclosure") -> tuple[str, str]:
        """Return the middles of two enclosures with as many digits as it takes to see that they differ."""
        for digits in range(8, MOST_DIGITS):
            mine = _truncated(self.mid, digits)
            others = _truncated(other.mid, digits)
            if mine != others:
                break
        return mine, others

    def __contains__(self, value: Number) -> bool:
        return self.low <= fraction(value, "value") <= self.high

    def __float__(self) -> float:
        return float(self.mid)

    def __str__(self) -> str:
        """Return the digits that both ends share, as in 2.545949602905103755[...]."""
        if self.low == self.high and self.low.denominator == 1:
            return str(self.low)
        if self.digits < 1:
            low = _truncated(self.low, _DIGITS_WITHOUT_CERTAINTY)
            high = _truncated(self.high, _DIGITS_WITHOUT_CERTAINTY)
            return f"[{low}, {high}]"
        for digits in range(min(self.digits + 1, _MOST_END_DIGITS), 0, -1):
            low = _truncated(self.low, digits)
            high = _truncated(self.high, digits)
            if low == high:
                return f"{low}[...]"
        return f"[{_truncated(self.low, self.digits + 1)}, {_truncated(self.high, self.digits + 1)}]"

    def __repr__(self) -> str:
        return f"Enclosure: {self}"


@dataclass(frozen=True, repr=False)
class EnclosedCriterion(Enclosure):
    """The value of a criterion between two numbers, and of what it is.

    Attributes
    ----------
    law : FrictionLaw
    criterion : Criterion
    V, N : sympy.Rational
        Belt speed in m/s and normal force in N.
    """

    law: FrictionLaw
    criterion: Criterion
    V: Rational
    N: Rational

    def certificate(self) -> str:
        """Return a Python script that encloses the value by itself, in python-flint and without this package.

        Raises `InputError` for a value of 0, or a law with a function that the script has no rule for.
        """
        from stickslip_sym.certificates.enclosures import certificate_of_enclosure

        return certificate_of_enclosure(self.law, self.criterion, self.V, self.N, self.low, self.high, str(self))


def _truncated(value: Fraction, digits: int) -> str:
    """Return a number with so many significant digits, the rest cut off."""
    if value == 0:
        return "0"
    with localcontext(Context(prec=digits, rounding=ROUND_DOWN, Emin=MIN_EMIN, Emax=MAX_EMAX)):
        number = Decimal(value.numerator) / Decimal(value.denominator)
    if -5 <= number.adjusted() < digits:
        return f"{number:.{digits - 1 - number.adjusted()}f}"
    return re.sub(r"e([+-])(\d)$", r"e\g<1>0\2", f"{number:.{digits - 1}e}")


def enclosure_of(value: arb) -> Enclosure:
    """Return the ends of a real ball; those nearer to 0 than 2^-100000 as 0 and that.

    Raises
    ------
    NotConverged
        For an end beyond 2^100000.
    """
    with working_precision(2 * _EXTREME):  # so the ends are exact
        return Enclosure(_exact_end(value.lower(), -1), _exact_end(value.upper(), 1))


def rounded_outward(ends: Enclosure) -> Enclosure:
    """Round both ends outwards, by a sixteenth of the radius at most.

    Arb keeps the nodes of its Gauss rules as precise as they were first needed. So the radius of an integral
    depends, in its seventh digit, on what was integrated before; the ends are not to.
    """
    if ends.radius == 0:
        return ends
    bits = ends.radius.numerator.bit_length() - ends.radius.denominator.bit_length()  # or one more than log2
    grid = Fraction(2) ** (bits - (ends.radius < Fraction(2) ** bits) - _BITS_FINER_THAN_RADIUS)
    return Enclosure(math.floor(ends.low / grid) * grid, math.ceil(ends.high / grid) * grid)


def _exact_end(end: arb, side: int) -> Fraction:
    mantissa, exponent = (int(part) for part in end.man_exp())
    if mantissa == 0:
        return Fraction(0)
    size = exponent + mantissa.bit_length()
    if size > _EXTREME:
        raise NotConverged(f"the value is beyond 2^{_EXTREME}, too large to be written")
    if size < -_EXTREME:
        if mantissa * side > 0:
            return Fraction(side, 2**_EXTREME)
        return Fraction(0)
    return Fraction(mantissa) * Fraction(2) ** exponent


def enclose(
    law: FrictionLaw | str,
    criterion: CriterionName | Criterion = "least_squares",
    *,
    V: Number,
    N: Number,
    digits: int = 30,
) -> EnclosedCriterion:
    """Enclose the damping coefficient of a criterion, c = -N * integral_{-1}^{1} w(s) mu'(V(1 + s)) ds.

    A weight that is a polynomial is integrated by parts, so that mu itself stands under the integral; the
    harmonic one over an angle, c = 4N/(pi V) * integral_0^{pi/2} mu(2 V sin^2 phi) cos(2 phi) dphi. Kinks part
    the way. The integrals are done by Arb: Gauss rules with proved bounds, halving where they are too wide.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    criterion : str or Criterion
    V : number
        Belt speed in m/s, positive. Like all numbers taken exactly: text as a decimal, a float as binary.
    N : number
        Normal force in N, not negative.
    digits : int
        Relative radius of the result, 10^-digits. Where the value is 0, or over 400 digits below its terms, the
        enclosure is what it is, and holds 0.

    Returns
    -------
    EnclosedCriterion
        In kg/s: `low` and `high`, and `certificate()`, a script that encloses it without this package.

    Raises
    ------
    InputError
        For an unbound law, unusable numbers, or a function that has no enclosure here.
    NotConverged
        If the integral is not enclosed, as where mu is infinite at v = 0.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> print(enclose(laws.exponential.typical(), V="0.5", N="9.81", digits=12))
    2.545949602905103755781[...]
    """
    law = as_law(law)
    criterion, speed, force = read_operating_point(law, criterion, V, N, digits)
    point = law.point
    if force == 0 or not law.expr.has(symbols.v):
        zero = Fraction(0)  # every criterion averages a slope
        return EnclosedCriterion(zero, zero, law, criterion, speed, force)

    def enclosed() -> arb:
        value = ball(force).real * average_enclosure(law.expr, point, criterion, ball(speed).real, speed)
        if not value.is_finite():
            raise NotConverged(
                f"the {criterion.name} criterion of {law.text} is not enclosed at V = {float(speed):g}"
            )
        return value

    goal = int(digits * _BITS_PER_DIGIT) + 2
    ends = rounded_outward(enclosure_of(refined(enclosed, goal, goal + _MOST_BITS_LOST)))
    return EnclosedCriterion(ends.low, ends.high, law, criterion, speed, force)


def average_enclosure(
    mu: Expr, point: Substitution, criterion: Criterion, speed: arb, exact: Expr | None = None
) -> arb:
    """Return a ball around -<mu'(V(1 + s))>_w at the working precision; not finite where none is found.

    `mu` is a function of `symbols.v`; `point` has the exact values of the others; the speed is positive. The
    slope at a kink is the mean of both, where `exact` says that the speed is there, and any between them where a
    ball may be.
    """
    reach = speed if criterion.weight is None else 2 * speed
    kinks = kinks_at(mu, point)
    inside = [place for place in kinks if ball(place).real < reach]
    ends_of_pieces = [sp.Integer(0), *kinks, 2 * kinks[-1] if kinks else sp.Integer(1)]
    pieces = smooth_pieces(mu, point, ends_of_pieces[: len(inside) + 2])
    if criterion.weight is None:
        there: Point = {**point, symbols.v: acb(speed)}
        near = [kink for kink in kinks if ball(kink).real.overlaps(speed)]
        if exact is not None:
            near = [kink for kink in near if kink == exact]
        sides = smooth_pieces(mu, point, [sp.Integer(0), *kinks, *ends_of_pieces[-1:]])
        sides = [side for kink in near for side in sides[kinks.index(kink) : kinks.index(kink) + 2]]
        slopes = [_real_ball(ball_value(sp.diff(side, symbols.v), there)).real for side in sides or pieces[-1:]]
        if not all(_real_ball(ball_value(side, there)).is_finite() for side in sides or pieces[-1:]):
            return arb.nan()
        if exact is not None:
            return -reduce(add, slopes) / len(slopes)
        return -reduce(arb.union, slopes)
    first, vanished = vanishing(pieces[0], point)
    parts = [balls_from_rest(first, point), *(ball_function(piece, symbols.v, point) for piece in pieces[1:])]
    if not _real_ball(parts[0](acb(0), False)).is_finite():
        return arb.nan()  # no panel that begins at v = 0 has a bound, however often it is halved
    V = acb(speed)
    places = [ball(place).real for place in inside]
    if criterion.is_polynomial:
        slope = ball_function(sp.diff(criterion.weight, symbols.s), symbols.s, {})
        scale = acb(1)
        ends = [acb(-1), *(acb(place / speed - 1) for place in places), acb(1)]
    else:
        scale = 4 / acb.pi()
        ends = [acb(0), *(acb((place / reach).sqrt().asin()) for place in places), acb.pi() / 2]

    def integrand(mu: BallFunction) -> BallFunction:
        def over_speed(s: acb, analytic: bool) -> acb:
            return slope(s, analytic) * on_axis(s, mu(V * (1 + s), analytic))

        def over_angle(phi: acb, analytic: bool) -> acb:
            sine = phi.sin()
            square = sine * sine
            return on_axis(phi, mu(2 * V * square, analytic)) * (1 - 2 * square)

        def on_axis(z: acb, value: acb) -> acb:
            return _real_ball(value) if z.imag == 0 else value

        return over_speed if criterion.is_polynomial else over_angle

    panels = zip(parts, pairwise(ends), strict=True)
    total = scale * reduce(add, [integrated(integrand(part), *panel) for part, panel in panels])
    low, high = criterion.ends
    bits = ctx.prec
    if (start := start_of(vanished, point, reach, bits)) is not None:
        if places:
            start = start.min(places[0].lower() / 2)
        # The variable tells the start from its end, where it is 1 + s and the start is far lower.
        with working_precision(ctx.prec + max(0, math.ceil(float((reach / start).log()) / math.log(2)))):
            if criterion.is_polynomial:
                share = start / speed
            else:
                share = (start / reach).sqrt().asin()
            most = abs(scale.real) * bound_below(vanished, point, start) * share * _kernel_bound(criterion)
            part = ball_function(vanished, symbols.v, point)
            # The absolute tolerance is that of values that may be as small as here at the end.
            size = abs(part(acb(places[0] if places else reach), False)) * arb(2) ** -bits
            total += scale * integrated(integrand(part), ends[0] + share, ends[1], abs_tol=size.lower())
            total += acb(arb(0, most.abs_upper()) if most.is_finite() else arb.nan())
        if high != 0 and len(parts) == 1:
            total -= ball(high) * part(2 * V, False)
    if low != 0:
        total += ball(low) * parts[0](acb(0), False)
    if high != 0:
        total -= ball(high) * parts[-1](2 * V, False)
    return (total / V).real


def _kernel_bound(criterion: Criterion) -> arb:
    """Return a bound on what mu is multiplied by under the integral."""
    if criterion.weight is None or not criterion.is_polynomial:
        return arb(1)
    slope = sp.Poly(sp.diff(criterion.weight, symbols.s), symbols.s)
    return ball(sum(map(abs, slope.all_coeffs()), sp.S.Zero)).real


def _real_ball(value: acb) -> acb:
    """Return a ball that may hold a real number; what cannot is no coefficient, and no ball."""
    if value.imag.contains(0):
        return value
    return acb(arb.nan())


def smooth_pieces(mu: Expr, point: Substitution, ends: Sequence[Expr]) -> list[Expr]:
    """Return mu between the ends, each piece chosen half-way: a kink itself may be rounded."""
    return [branch_from(mu, point, (left + right) / 2) for left, right in pairwise(ends)]
