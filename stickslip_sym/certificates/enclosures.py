"""An enclosed criterion as a script in python-flint alone: nothing of this package is needed to run it."""

import textwrap
from fractions import Fraction
from pathlib import Path
from string import Template

import sympy as sp

from stickslip_sym.certificates import in_flint
from stickslip_sym.certificates.in_flint import WIDTH, LawInFlint
from stickslip_sym.certificates.script import imported
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Call
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.decay import vanishing
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output import printing
from stickslip_sym.output.sections import sections

_GUARD = 64  # bits beyond those of the enclosure


def certificate_of_enclosure(
    law: FrictionLaw, criterion: Criterion, V: Rational, N: Rational, low: Fraction, high: Fraction, shown: str
) -> str:
    """Return the script that encloses a criterion between two numbers by itself; `shown` are its certain digits.

    Raises `InputError` for a law with a function that the script has no rule for, or a value of exactly 0.
    """
    page = sections(Path(__file__).with_suffix(".txt"))
    if low >= high or low <= 0 <= high:
        raise InputError(f"c is {shown}: a certificate is for a value with a certain digit; ask for more digits")
    if vanishing(law.kinetic.segments[0][1], law.point)[1] != 0 and criterion.weight is not None:
        raise InputError(
            f"mu(v) = {law.text} vanishes at rest faster than any power of v, for which the script has no rule; "
            "the closed form, where there is one, is proved by ",
            Call("derive(law).certificate()", "export LAW --certificate FILE.py"),
        )
    script = LawInFlint(law.kinetic, "".join(page.values()), with_series=False)
    if criterion.weight is None:
        sides = _at_the_belt_s_speed(script, V)
        kind, definition = "equilibrium", "c = -N mu'(V)"
        slopes = [sp.diff(piece, symbols.v) for piece in sides]
        pieces = script.functions_of_v("SLOPES", "mu' at the belt's speed, on both sides of a kink", slopes)
        fields = {"slopes": f"sum(acb(slope(acb(V))) for slope in SLOPES) / {len(sides)}"}
    else:
        kinks = [end for end, speed in zip(script.ends, script.starts[1:], strict=False) if speed < 2 * V]
        kind = "polynomial" if criterion.is_polynomial else "harmonic"
        ends = [*kinks, "2 * V"]
        if kind == "harmonic":
            ends = [*(f"({kink} / (2 * V)).sqrt().asin()" for kink in kinks), "arb.pi() / 2"]
        definition = f"c = -N int_-1^1 w(s) mu'(V (1 + s)) ds, w(s) = {printing.text(criterion.weight)}"
        pieces = script.functions_of_v("MU", "the smooth pieces of mu", script.pieces[: len(ends)])
        fields = {"ends": in_flint.listed(ends, WIDTH - 40), "boundary": "", "factor": "4 * N / (arb.pi() * V)"}
        if kind == "polynomial":
            slope = sp.factor(sp.diff(criterion.weight, symbols.s))
            fields |= {
                "slope": script.text(slope),
                "factor": "N / (V * V)",
                "boundary": _boundary(script, criterion),
            }
        page[kind] += page["sum"]
    lines = textwrap.wrap(f"    mu(v) = {law.text},", WIDTH, subsequent_indent=" " * 8)
    text = Template(page["page"]).safe_substitute(
        name=criterion.name,
        law="\n".join(lines),
        definition=definition,
        bits=_bits(low, high) + _GUARD,
        scene=f"{in_flint.number(V)}, {in_flint.number(N)}",
        parameters=script.parameters,
        low=_dyadic(low),
        high=_dyadic(high),
        pieces=pieces,
        body=Template(page[kind].rstrip()).substitute(fields),
        functions=script.functions,
    )
    names = imported(text.split("import", 1)[1], ("acb", "arb", "arb_series", "ctx", "fmpq"))
    return Template(text).substitute(imports=names)


def _at_the_belt_s_speed(script: LawInFlint, V: Rational) -> list[Expr]:
    """Return the piece of mu at the belt's speed; at a kink both pieces that meet there."""
    last = max(i for i, start in enumerate(script.starts) if start <= V)
    return script.pieces[last - (script.starts[last] == V) : last + 1]


def _boundary(script: LawInFlint, criterion: Criterion) -> str:
    """Return what integration by parts leaves at v = 0 and at 2 V, where the weight is not 0."""
    ends = zip(criterion.ends, ("MU[0](arb(0))", "-MU[-1](2 * V)"), strict=True)
    terms = [f"{mu} * V * {script.text(weight)}" for weight, mu in ends if weight != 0]
    return "".join(f"c += {term}\n" for term in terms)


def _dyadic(end: Fraction) -> str:
    """Return the numerator and the denominator, a power of two, of an end."""
    return f"{end.numerator}, 2**{end.denominator.bit_length() - 1}"


def _bits(low: Fraction, high: Fraction) -> int:
    """Return how many bits of what lies between two ends are certain, about."""
    ratio = abs(low + high) / (high - low)
    return max(1, ratio.numerator.bit_length() - ratio.denominator.bit_length())
