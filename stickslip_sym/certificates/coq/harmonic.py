"""The harmonic criterion of laws with a rational slope in Coq, over the angle t of v = V (1 - cos t).

sin(t)^2 mu'(v) is the derivative of a function that the proof supplies, and for each pole of mu' a multiple of one
fraction, whose integral the library has: 1/(v + w), or 1/q and v/q with q = v^2 + b v + c, complex zeros.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import sympy as sp

from stickslip_sym.certificates.coq.printer import Unsupported
from stickslip_sym.certificates.coq.tactics import Script, unfolded
from stickslip_sym.certificates.coq.words import Generators, denominators, require_regular, roots_of
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.remedies import Call
from stickslip_sym.formula.finding.matching import minus_discriminant, partial_fractions
from stickslip_sym.model.terms import Term
from stickslip_sym.output import printing

V, v = symbols.V, symbols.v
_CONSTANT = Term(sp.S.One, sp.S.One, sp.S.One)


@dataclass(frozen=True)
class Pole:
    """A multiple of a fraction top/base of v, base monic of degree 1 or 2, top 1 or v."""

    multiple: Expr
    top: Expr
    base: Expr

    @cached_property
    def coefficients(self) -> list[Expr]:
        """Those of the base, but for the first, which is 1."""
        return list(sp.Poly(self.base, v).all_coeffs()[1:])

    @cached_property
    def roots(self) -> list[Expr]:
        """The roots in its integral: S, or m, X and Z of the library."""
        if len(self.coefficients) == 1:
            (w,) = self.coefficients
            return [sp.sqrt(w) * sp.sqrt(w + 2 * V)]
        b, c = self.coefficients
        m = sp.sqrt(c)
        X = sp.sqrt(c + 2 * b * V + 4 * V**2)
        return [m, X, sp.expand_power_base(sp.sqrt(2 * sp.factor(c + b * V + m * X)))]

    @cached_property
    def integral(self) -> Expr:
        """The integral of the fraction over the angle."""
        if len(self.coefficients) == 1:
            return sp.pi / self.roots[0]
        m, X, Z = self.roots
        if self.top == 1:
            return sp.pi * (m + X) / (Z * m * X)
        return 2 * sp.pi * V / (Z * X)


@dataclass(frozen=True)
class SlopeTerm:
    """A term of mu', but for its amplitude: sin(t)^2 times it is (rate t + sin(t) wave(v))' and its poles."""

    label: int
    term: Term
    amplitude: Expr
    slope: Expr
    rate: Expr
    wave: Expr
    poles: tuple[Pole, ...]

    @property
    def supplied(self) -> list[Expr]:
        """What the proof supplies of it."""
        return [self.amplitude, self.slope, self.rate, self.wave, *(pole.multiple for pole in self.poles)]

    @property
    def integral(self) -> Expr:
        """The integral of sin(t)^2 times it from 0 to pi."""
        return self.rate * sp.pi + sp.Add(*[pole.multiple * pole.integral for pole in self.poles])


class Harmonic(Script):
    """A script on the criterion whose weight is (2/pi) sqrt(1 - s^2)."""

    @cached_property
    def rows(self) -> list[SlopeTerm]:
        """The terms of mu' that are not 0; one that is 0, where all are."""
        moving = [term for term in self.form.terms if term.profile.has(v)]
        return [self._row(label, term) for label, term in enumerate(moving or [_CONSTANT], 1)]

    def _row(self, label: int, term: Term) -> SlopeTerm:
        """Return a term of mu' with what the proof supplies of it."""
        parts = partial_fractions(sp.diff(term.in_parameters(term.profile), v), v)
        if parts is None:
            raise Unsupported(
                "a script in Coq has the harmonic criterion of slopes that are quotients of polynomials of v, "
                f"with positive factors of degree 1 and 2, and no rule for {printing.text(term.expr)}; "
                "the certificate in SymPy proves it: ",
                Call('form.certificate("sympy")', "export LAW --certificate FILE.py"),
            )
        polynomial, fractions = parts
        slope = polynomial
        rate, wave, _ = slope_over_angle(polynomial, sp.S.One, 1)
        multiples = dict[tuple[Expr, Expr], Expr]()
        for numerator, coefficients, power in fractions:
            base = _base_of(coefficients)
            more_rate, more_wave, more_multiples = slope_over_angle(numerator, base, power)
            slope += numerator / base**power
            rate += more_rate
            wave += more_wave
            for top, multiple in more_multiples.items():
                multiples[top, base] = multiples.get((top, base), sp.S.Zero) + multiple
        poles = [Pole(sp.factor(multiple), *of) for of, multiple in multiples.items()]
        return SlopeTerm(
            label,
            term,
            self.words(term.amplitude, self.v),
            slope,
            sp.factor(rate),
            wave,
            tuple(pole for pole in poles if pole.multiple != 0),
        )

    def text(self) -> str:
        """Return the script."""
        law = self.form.law.expr
        weight = cast(Expr, self.form.criterion.weight)  # that of one point has another script
        if weight != 2 * sp.sqrt(1 - symbols.s**2) / sp.pi:
            raise Unsupported(f"a script in Coq has no weight {printing.text(weight)}")
        v = self.v
        mu = self.words(law, v)
        c = self.words(self.form.expr, v)
        shares = {term: self.words(share, v) for term, share in self.form.shares}
        require_regular(v, mu, *[self.words(row.slope, v) for row in self.rows], at_rest=True)
        in_code = " + ".join(f"({self.code(share)})" for share in shares.values()) or self.code(c)
        supplied = [self.words(expr, v) for row in self.rows for expr in row.supplied]
        excluded = denominators(c, mu, *supplied, without=(v,))
        law_text = self.law(mu, in_code, excluded, self.part("weight"))
        terms = "\n".join(map(self._over_angle, self.rows))
        amplitudes = [(self.whole(row.amplitude), row.label) for row in self.rows]
        joined = ""
        for amplitude, label in amplitudes:
            joined = _proof_of_sum(joined, f"(integral_times {amplitude} _ _ _ _ angle{label})")
        proof = self.part(
            "harmonic",
            terms=terms,
            slope=" + ".join(f"{amplitude} * slope{label} v" for amplitude, label in amplitudes),
            slopes=", ".join(f"slope{label}" for _, label in amplitudes),
            values=" + ".join(f"{amplitude} * I{label}" for amplitude, label in amplitudes),
            integrand=" + ".join(
                f"{amplitude} * (sin t ^ 2 * slope{label} (speed t))" for amplitude, label in amplitudes
            ),
            integrals=joined,
            shares="\n".join(self._share(row, shares[row.term]) for row in self.rows if shares),
            c_equality=self._by_shares() if shares else self._at_once(c),
        )
        return self.assembled(law_text, proof)

    # -- one term ------------------------------------------------------------------------------------

    def _over_angle(self, row: SlopeTerm) -> str:
        """State and prove the integral of a term over the angle."""
        names = [f"pole{row.label}_{i}" for i in range(len(row.poles))]
        multiples = [self.whole(self.words(pole.multiple, self.v)) for pole in row.poles]
        fractions = [f"{m} * ({self._fraction(pole)})" for m, pole in zip(multiples, row.poles, strict=True)]
        integrals = [f"{m} * ({self._integral(pole)})" for m, pole in zip(multiples, row.poles, strict=True)]
        joined = f"rest{row.label}"
        for name, multiple in zip(names, multiples, strict=True):
            joined = _proof_of_sum(joined, f"(integral_times {multiple} _ _ _ _ {name})")
        angle = sp.Symbol("t")
        self.names[angle] = "t"
        sine = sp.Function("sin")(angle)
        cosine = sp.Function("cos")(angle)
        rate = self.words(row.rate, self.v)
        wave = self.words(row.wave, self.v)
        rise = rate * angle + sine * wave.xreplace({self.v: V * (1 - cosine)})
        bases = dict.fromkeys(pole.base for pole in row.poles)
        return self.part(
            "angle",
            label=row.label,
            slope=self.code(self.words(row.slope, self.v)),
            rise=self.code(rise),
            value=" + ".join([f"{self.whole(rate)} * PI", *integrals]),
            poles="\n".join(map(self._pole, names, row.poles)),
            remaining="".join(f" - {fraction}" for fraction in fractions),
            restored="".join(f" + {fraction}" for fraction in fractions),
            risen="".join(f" + {integral}" for integral in integrals),
            positive="".join(map(self._positive, bases)),
            integrals=joined,
        )

    def _fraction(self, pole: Pole) -> str:
        """Return the fraction as the library has it."""
        top = "/" if pole.top == 1 else "speed t /"
        return f"{top} ({self._base(pole, 'speed t')})"

    def _base(self, pole: Pole, speed: str) -> str:
        texts = [self.whole(self.words(coefficient, self.v)) for coefficient in pole.coefficients]
        if len(texts) == 1:
            return f"{speed} + {texts[0]}"
        return f"({speed}) ^ 2 + {texts[0]} * ({speed}) + {texts[1]}"

    def _integral(self, pole: Pole) -> str:
        """Return the integral of the fraction as the library has it."""
        texts = [self.whole(self.words(root, self.v)) for root in pole.roots]
        if len(texts) == 1:
            return f"PI / {texts[0]}"
        m, X, Z = texts
        if pole.top == 1:
            return f"PI * ({m} + {X}) / ({Z} * {m} * {X})"
        return f"2 * PI * V / ({Z} * {X})"

    def _pole(self, name: str, pole: Pole) -> str:
        """State and prove the integral of a fraction over the angle."""
        lemma = "linear_pole"
        given = list(pole.coefficients)
        if len(given) == 2:
            lemma = "quadratic_pole" if pole.top == 1 else "quadratic_pole_at_speed"
            given.append(minus_discriminant(*pole.coefficients))
        roots = [self.words(root, self.v) for root in pole.roots]
        facts, using = self.facts(roots_of(*roots))
        arguments = [self.words(expr, self.v) for expr in given] + roots
        return self.part(
            "pole",
            pole=name,
            fraction=self._fraction(pole),
            integral=self._integral(pole),
            facts=facts,
            lemma=" ".join([lemma, "V", *map(self.whole, arguments)]),
            using=using,
        )

    def _positive(self, base: Expr) -> str:
        """Return a tactic that states that a base is positive at each angle."""
        pole = Pole(sp.S.One, sp.S.One, base)
        if len(pole.coefficients) == 1:
            return ""
        given = [*pole.coefficients, minus_discriminant(*pole.coefficients)]
        texts = " ".join(self.whole(self.words(x, self.v)) for x in given)
        return f" pose proof (quadratic_positive {texts} (speed t) ltac:(positive) ltac:(field; positive));"

    # -- the criterion -------------------------------------------------------------------------------

    def _value(self, row: SlopeTerm) -> Expr:
        return self.words(row.integral, self.v)

    def _at_once(self, c: Expr) -> str:
        """Prove that c is the sum of the terms, by one equation."""
        values = map(self._value, self.rows)
        amplitudes = [row.amplitude for row in self.rows]
        return self._equal(c, [*values, *amplitudes], ["c", *(f"I{row.label}" for row in self.rows)])

    def _equal(self, c: Expr, others: Sequence[Expr], names: Sequence[str]) -> str:
        """Prove an equation in which expressions stand, some of them by name."""
        equation = self.equation(Generators([c, *others]), c, *others)
        return f"unfold {', '.join(names)}{unfolded(c, *others)}. {equation}"

    def _share(self, row: SlopeTerm, share: Expr) -> str:
        """State and prove what a term adds to c."""
        return self.part(
            "share_over_angle",
            label=row.label,
            share=self.code(share),
            amplitude=self.whole(row.amplitude),
            equality=self._equal(share, [self._value(row), row.amplitude], [f"I{row.label}"]),
        )

    def _by_shares(self) -> str:
        """Prove that c is the sum of the terms, by what each of them adds."""
        joined = ""
        for row in self.rows:
            joined = f"(f_equal2 Rplus {joined} share{row.label})" if joined else f"share{row.label}"
        return f"unfold c. refine (eq_trans {joined} _). field; positive."


def _base_of(coefficients: Sequence[Expr]) -> Expr:
    """Return the base of a fraction, linear or with complex zeros."""
    base = sp.Add(*[c * v**i for i, c in enumerate(reversed(coefficients))])
    if len(coefficients) == 3 and not minus_discriminant(*coefficients[1:]).is_positive:
        raise Unsupported(
            f"a script in Coq has no harmonic criterion of a fraction over {printing.text(base)}, whose zeros are "
            "not known to be complex"
        )
    return base


def _proof_of_sum(first: str, second: str) -> str:
    """Return the proof of the integral of a sum, of those of its two parts."""
    if first:
        return f"(integral_plus _ _ _ _ _ _ {first} {second})"
    return second


def slope_over_angle(numerator: Expr, base: Expr, power: int) -> tuple[Expr, Expr, dict[Expr, Expr]]:
    """Return rate, wave and multiples of fractions of numerator/base^power, as a slope over the angle.

    With sin(t)^2 = v (2 V - v)/V^2, and (sin(t) W(v))' = (1 - v/V) W + v (2 V - v)/V W', all is rational in v: the
    coefficients of W, a polynomial over base^(power - 1) and one beside it, solve linear equations.
    """
    square = v * (2 * V - v) / V
    degree = 0
    if base.has(v):
        degree = int(sp.degree(base, v))
    above = sp.expand(square / V * numerator)
    surplus = 0
    if above != 0:
        surplus = max(int(sp.degree(above, v)) - degree * power, 0)
    rate = sp.Dummy("rate")
    near = sp.symbols(f"a:{degree * (power - 1)}", cls=sp.Dummy)
    far = sp.symbols(f"b:{surplus}", cls=sp.Dummy)
    rates = sp.symbols(f"c:{degree}", cls=sp.Dummy)
    wave = sp.Add(*[a * v**i for i, a in enumerate(near)]) / base ** (power - 1)
    wave += sp.Add(*[b * v**i for i, b in enumerate(far)])
    left = rate + (1 - v / V) * wave + square * sp.diff(wave, v)
    left += sp.Add(*[c * v**i for i, c in enumerate(rates)]) / base
    equations = sp.Poly(sp.cancel((left - above / base**power) * base**power * V**2), v).all_coeffs()
    unknown = [rate, *near, *far, *rates]
    (solution,) = sp.linsolve(equations, unknown)
    value = dict(zip(unknown, map(sp.factor, solution), strict=True))
    return value[rate], wave.xreplace(value), {v**i: value[c] for i, c in enumerate(rates)}
