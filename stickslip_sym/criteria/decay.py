"""Coefficients that vanish at rest faster than any power of v, such as exp(-g/v): how they fall, and bounds.

No ball around v = 0 is finite there. What such a coefficient adds below some speed is bounded by its value at that
speed, since it rises from 0; above it balls are as small as they are anywhere.
"""

from dataclasses import dataclass

import sympy as sp
from flint import acb, arb, arb_poly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.balls import ball, ball_value, number_at


@dataclass(frozen=True)
class Decay:
    """exp(-rate v^-order) with rate and order > 0."""

    rate: Expr
    order: Expr

    @property
    def function(self) -> Expr:
        """It at v = 2 V."""
        return sp.exp(-self.rate * (2 * symbols.V) ** -self.order)

    def exponent(self, v: arb) -> arb:
        """Return rate v^-order."""
        return ball(self.rate).real * v ** (-ball(self.order).real)

    def ball(self, v: arb) -> arb:
        """Return it at a speed."""
        return (-self.exponent(v)).exp()

    def steepness(self, v: float) -> float:
        """Return by how much more its relative error is than that of the speed."""
        return float(self.exponent(arb(v)) * ball(self.order).real)

    def below(self, reach: arb, bits: int) -> arb:
        """Return a speed where it is so many bits below what it is at another one."""
        rate = ball(self.rate).real
        order = ball(self.order).real
        return ((reach ** (-order) + bits * arb.const_log2() / rate) ** (-1 / order)).mid()


@dataclass(frozen=True)
class DecayInLogarithm:
    """exp(P(log(v))), P a polynomial of degree 2 or more falling without bound at rest: a log-normal law."""

    coefficients: tuple[arb, ...]

    def exponent(self, logarithm: arb) -> arb:
        """Return P of a logarithm of the speed."""
        return arb_poly(list(self.coefficients))(logarithm)

    def rises_below(self, logarithm: arb, power: arb) -> bool:
        """Whether v^power exp(P(log(v))) rises with v up to a speed: its rate is positive for every t below."""
        rate = arb_poly(list(self.coefficients)).derivative() + power
        in_distance = rate(arb_poly([logarithm, -1]))
        return all(bool(c >= 0) for c in in_distance) and bool(in_distance[0] > 0)

    def below(self, reach: arb, bits: int) -> arb:
        """Return a speed where it is so many bits below what it is at another one, or lower."""
        top = reach.log()
        step = arb(1)
        wanted = self.exponent(top) - bits * arb.const_log2()
        while not (self.exponent(top - step) < wanted and self.rises_below(top - step, arb(0))):
            step *= 2
        return (top - step).exp().mid()


def _decay_in_logarithm(node: Expr, point: Substitution) -> DecayInLogarithm | None:
    """Return an exponential of a polynomial in log(v) that falls without bound at rest; None for another."""
    if not node.exp.has(sp.log):
        return None
    logarithm = sp.log(symbols.v)
    exponent = sp.expand(sp.expand_log(node.exp, force=True))
    if not exponent.is_polynomial(logarithm) or sp.Poly(exponent, logarithm).degree() <= 1:  # a power of v
        return None
    coefficients = sp.Poly(exponent, logarithm).all_coeffs()[::-1]
    if any(c.has(symbols.v) or c.free_symbols - point.keys() for c in coefficients):
        return None
    balls = tuple(ball_value(c, point).real for c in coefficients)
    falls = bool(balls[-1] * (-1) ** (len(balls) - 1) < 0)
    return DecayInLogarithm(balls) if falls else None


def start_of(mu: Expr, point: Substitution, reach: arb, bits: int) -> arb | None:
    """Return a speed below which what vanishes faster than any power counts for nothing; None without such."""
    decay = decay_at_rest(mu, point)
    logarithmic = [_decay_in_logarithm(node, point) for node in mu.atoms(sp.exp)]
    starts = [one.below(reach, bits) for one in logarithmic if one is not None]
    if decay is not None:
        starts += [decay.below(reach, bits)]
    return min(starts, key=float, default=None)


def decay_at_rest(mu: Expr, point: Substitution) -> Decay | None:
    """Return the slowest exponential by which a smooth coefficient, or a term of it, vanishes at rest."""
    decays = [_leading_decay(node, point) for node in mu.atoms(sp.exp)]
    known = [decay for decay in decays if decay is not None]
    return min(known, key=lambda decay: (decay.order, decay.rate), default=None)


def _leading_decay(node: Expr, point: Substitution) -> Decay | None:
    terms = _exponent_powers(node, point)
    if not terms:
        return None
    power, rate = min(terms)
    if power < 0 and rate < 0:
        return Decay(-rate, -power)
    return None


def _exponent_powers(node: Expr, point: Substitution) -> list[tuple[Expr, Expr]]:
    """Return exponents and coefficients of an exponential's argument; nothing if it is no sum of powers of v."""
    powers: dict[Expr, Expr] = {}
    for term in sp.Add.make_args(sp.expand(node.exp)):
        coefficient, power = sp.expand_power_base(term, force=True).as_coeff_exponent(symbols.v)
        if coefficient.has(symbols.v) or (coefficient.free_symbols | power.free_symbols) - point.keys():
            return []
        power = number_at(power, point)
        powers[power] = powers.get(power, sp.S.Zero) + number_at(coefficient, point)
    if all(c.is_real for c in powers.values()):
        return [(power, c) for power, c in powers.items() if c != 0]
    return []


def vanishing(mu: Expr, point: Substitution) -> tuple[Expr, Expr]:
    """Return a smooth coefficient without its terms that vanish faster than any power, and these."""
    regular = list[Expr]()
    vanished = list[Expr]()
    for term in sp.Add.make_args(sp.expand_mul(mu)):
        exponentials = [factor for factor in sp.Mul.make_args(term) if isinstance(factor, sp.exp)]
        decays = any(_leading_decay(node, point) or _decay_in_logarithm(node, point) for node in exponentials)
        (vanished if decays else regular).append(term)
    return sp.Add(*regular), sp.Add(*vanished)


def bound_below(vanished: Expr, point: Substitution, end: arb) -> arb:
    """Return a bound on what vanishes faster than any power, from v = 0 to a speed; not finite without one."""
    around = acb(arb(end / 2, (end / 2).abs_upper()))
    total = arb(0)
    for term in sp.Add.make_args(vanished):
        size = arb(1)
        power = sp.S.Zero
        exponent = arb(0)
        order = arb(0)
        logarithmic = None
        for factor in sp.Mul.make_args(term):
            base, p = factor.as_base_exp()
            decay = _leading_decay(factor, point) if isinstance(factor, sp.exp) else None
            if decay is not None and exponent == 0:
                leading = decay.exponent(end)
                order = ball(decay.order).real
                others = [abs(ball(c).real) * end ** ball(e).real for e, c in _exponent_powers(factor, point)
                          if e != -decay.order]  # fmt: skip
                beside = sum(others, arb(0))
                if not beside <= leading / 2:  # then it is less, the lower the speed
                    return arb.nan()
                exponent = leading - beside
            elif (
                logarithmic is None
                and isinstance(factor, sp.exp)
                and _decay_in_logarithm(factor, point) is not None
            ):
                logarithmic = _decay_in_logarithm(factor, point)
            elif base == symbols.v and not p.has(symbols.v):
                power += p
            else:
                size *= abs(ball_value(factor, {**point, symbols.v: around}).real)
        lowered = ball_value(sp.sympify(power), point).real
        if logarithmic is not None:
            if exponent != 0 or not logarithmic.rises_below(end.log(), lowered):
                return arb.nan()
            total += size * (logarithmic.exponent(end.log()) + lowered * end.log()).exp()
            continue
        if not exponent * order >= -lowered:  # so far v^power times the exponential rises
            return arb.nan()
        total += size * end**lowered * (-exponent).exp()
    return total
