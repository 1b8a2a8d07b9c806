"""Letters for the numbers in the formula of a law, where a closed form mixes them into huge integers."""

from collections.abc import Iterator

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError, NoClosedForm
from stickslip_sym.core.special import NumberPower
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output.text_printer import is_decimal, is_over_decimal

_READABLE = 10**5
"""An integer, or a denominator, that is larger was multiplied together from the numbers of a law."""
_AT_A_GLANCE = 100
"""Numbers of a law with a larger numerator or denominator get a letter."""


def lettered(form: ClosedForm) -> tuple[ClosedForm, dict[Expr, Expr]]:
    """Return a form whose long numbers have letters, and the number that each letter stands for.

    The letters are parameters of a law like the others, whose form is derived, and proved for every value of them.
    A form of short integers is returned as it is.
    """
    law = form.law
    mixed = [number for number in form.expr.atoms(sp.Rational) if not is_decimal(number)]
    if law.curve is not None or max(map(_size, mixed), default=0) <= _READABLE:
        return form, {}
    long = sorted({_positive(number) for number in _numbers(law.expr)}, key=sp.default_sort_key)
    free = (letter for letter in "aqphgz" if not any(name.startswith(letter) for name in law.parameters))
    letter = next(free, "number")
    given = [Parameter(f"{letter}_{count}") for count in range(1, len(long) + 1)]
    letters, written = dict[Expr, Expr](), dict[Expr, Expr]()
    for number, symbol in zip(long, (letter.symbol for letter in given), strict=True):
        inverse = number.is_Rational and is_over_decimal(number)
        letters[symbol] = 1 / number if inverse else number
        written |= {sign * number: sign * (1 / symbol if inverse else symbol) for sign in (1, -1)}
    try:
        general = FrictionLaw(law.expr.xreplace(written), parameters=[*law.parameters.values(), *given])
        return derive(general, form.criterion, search=False), letters
    except (InputError, NoClosedForm):  # a number was needed to decide something
        return form, {}


def _size(number: Expr) -> int:
    return max(abs(int(number.p)), int(number.q))


def _positive(number: Expr) -> Expr:
    return abs(number) if number.is_Rational else number


def _numbers(expr: Expr) -> Iterator[Expr]:
    """Yield the long numbers of an expression, but for exponents."""
    if isinstance(expr, NumberPower) or (expr.is_Rational and _size(expr) > _AT_A_GLANCE):
        yield expr
        return
    for argument in expr.args[: 1 if expr.is_Pow and expr.base is not sp.E else None]:
        yield from _numbers(argument)
