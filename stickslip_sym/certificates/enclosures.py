"""An enclosed criterion as a script in python-flint alone: nothing of this package is needed to run it."""

import textwrap
from fractions import Fraction
from pathlib import Path
from string import Template

import sympy as sp

from stickslip_sym.certificates import in_flint
from stickslip_sym.certificates.in_flint import LawInFlint
from stickslip_sym.certificates.python_printer import WIDTH
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.precision import GUARD_BITS
from stickslip_sym.core.remedies import Call
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.decay import vanishing
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output import printing


def certificate_of_enclosure(
    law: FrictionLaw, criterion: Criterion, V: Rational, N: Rational, low: Fraction, high: Fraction, shown: str
) -> str:
    """Return the script that encloses a criterion between two numbers by itself; `shown` are its certain digits.

    Raises `InputError` for a law with a function that the script has no rule for, or a value of exactly 0.
    """
    page = Path(__file__).with_suffix(".txt").read_text(encoding="utf-8")
    if low >= high or low <= 0 <= high:
        raise InputError(f"c is {shown}: a certificate is for a value with a certain digit; ask for more digits")
    if vanishing(law.kinetic.segments[0][1], law.point)[1] != 0 and criterion.weight is not None:
        raise InputError(
            f"mu(v) = {law.text} vanishes at rest faster than any power of v, for which the script has no rule; "
            "the closed form, where there is one, is proved by ",
            Call("derive(law).certificate()", "export LAW --certificate FILE.py"),
        )
    script = LawInFlint(law.kinetic, page)
    definition = "c = -N mu'(V)"
    weight = "None"
    if criterion.weight is not None:
        definition = f"c = -N int_-1^1 w(s) mu'(V (1 + s)) ds, w(s) = {printing.text(criterion.weight)}"
        weight = _coefficients(criterion.weight) if criterion.is_polynomial else '"harmonic"'
    ends = ['"0"', *(f'"{end}"' for end in script.ends), *(["None"] if law.kinetic.end is None else [])]
    lines = textwrap.wrap(f"    mu(v) = {law.text},", WIDTH, subsequent_indent=" " * 8)
    return Template(page).substitute(
        name=criterion.name,
        law="\n".join(lines),
        definition=definition,
        bits=_bits(low, high) + GUARD_BITS,
        scene=f"{in_flint.flint_rational(V)}, {in_flint.flint_rational(N)}",
        parameters=script.parameters,
        low=_dyadic(low),
        high=_dyadic(high),
        pieces=script.functions_of_v("MU", "the smooth pieces of mu", script.pieces),
        ends=in_flint.listed(ends, WIDTH - 80),
        weight=weight,
        functions=in_flint.FUNCTIONS,
    )


def _coefficients(weight: Expr) -> str:
    """Return the coefficients of a polynomial weight, from s^0 on."""
    return in_flint.listed([in_flint.flint_rational(a) for a in reversed(sp.Poly(weight, symbols.s).all_coeffs())])


def _dyadic(end: Fraction) -> str:
    """Return the numerator and the denominator, a power of two, of an end."""
    return f"{end.numerator}, 2**{end.denominator.bit_length() - 1}"


def _bits(low: Fraction, high: Fraction) -> int:
    """Return how many bits of what lies between two ends are certain, about."""
    ratio = abs(low + high) / (high - low)
    return max(1, ratio.numerator.bit_length() - ratio.denominator.bit_length())
