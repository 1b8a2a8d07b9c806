"""A proved threshold as a script in python-flint alone: nothing of this package is needed to run it.

The page `thresholds.txt` follows the slip from P as `boxes` does, in one piece for a reader. The law, the
operating point, both dampings, and what the theorem says of them in words are put in.
"""

import math
import textwrap
from fractions import Fraction
from pathlib import Path
from string import Template

import sympy as sp
from flint import arb

from stickslip_sym.certificates import in_flint
from stickslip_sym.certificates.in_flint import LawInFlint
from stickslip_sym.certificates.python_printer import WIDTH
from stickslip_sym.core.precision import GUARD_BITS, working_precision
from stickslip_sym.motion.thresholds.boxes import ExactPoint, Undecided, flow
from stickslip_sym.output.sections import sections


def certificate_of_threshold(
    point: ExactPoint,
    ends: tuple[Fraction, Fraction],
    bits: int,
    is_undamped: bool,
    statement: str,
    given: list[str],
) -> str:
    """Return the script that proves a theorem by itself.

    - `ends`: dampings at which the slip from P returns, and at which it does not.
    - `bits`: the precision with which that was decided.
    - `is_undamped`: whether it was shown to return without damping too.
    - `statement`, `given`: the theorem in a sentence, and what it needs of the law.

    Raises `InputError` for a law with a function that the script has no rule for.
    """
    law = point.law
    page = sections(Path(__file__).with_suffix(".txt"))
    script = LawInFlint(law.bound, page["page"])
    bits += GUARD_BITS + _widening(point, ends[1])
    with working_precision(bits):
        begins_analytic = _is_analytic_at_rest(point)
    borders = [f'"{end}"' for end in script.ends] + ["None"] * (law.v_max is None)
    conditions = [*given, "mu is bounded below at the slip speeds that are reached",
                   "c_1 >= 0, or the slip at c_1 is followed here"]  # fmt: skip
    return Template(page["page"] + "\n").substitute(
        law=textwrap.fill(f"mu(v) = {law.text}, v = V - x'", WIDTH - 4, subsequent_indent=" " * 8),
        statement=textwrap.fill(f"Theorem. {statement}", WIDTH),
        conditions=textwrap.fill(f"Conditions. {'; '.join(conditions)}.", WIDTH),
        bits=bits,
        scene=", ".join(map(in_flint.flint_rational, (point.V, point.N, point.m, point.k))),
        parameters=script.parameters,
        ends=", ".join(f"fmpq({end.numerator}, {end.denominator})" for end in ends),
        pieces=script.functions_of_v("MU", "the smooth pieces of mu", script.pieces),
        static="None" if law.static is None else f'"{script.text(law.static)}"',
        ends_of_pieces=in_flint.listed(['"0"', *borders], WIDTH - 80),
        functions=in_flint.FUNCTIONS,
        by_bounds=not begins_analytic,
        undamped=is_undamped,
    )


def _widening(point: ExactPoint, c: Fraction) -> int:
    """Return how many bits boxes lose over one slip, about 2 pi long, where the script's field does not cancel.

    Its damping and the falling friction, both of about the rate c/sqrt(k m), widen boxes by their sum.
    """
    rate = 2 * float(c) / math.sqrt(point.k * point.m)
    return math.ceil(2 * math.pi * rate / math.log(2))


def _is_analytic_at_rest(point: ExactPoint) -> bool:
    """Return whether the slip from P begins with a Taylor step, at the working precision."""
    try:
        flow(point.segments(sp.Integer(0))[0], arb(0), arb(0), 2)
    except Undecided:
        return False
    return True
