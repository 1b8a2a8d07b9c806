"""Whether the coefficient of friction is locally Lipschitz for v > 0, shown in ball arithmetic.

The nodes of a formula are analytic functions but for a few: a fraction at a zero of its denominator, a root or a
logarithm where its argument is not positive, a tangent at its poles. So it is enough to show that each of these
arguments is positive for v > 0, and that segments of mu meet without a jump.
"""

import math
from collections.abc import Iterator

import sympy as sp
from flint import acb

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import ball, ball_function
from stickslip_sym.core.functions import must_be_positive
from stickslip_sym.core.numbers import DOUBLE_BITS
from stickslip_sym.core.precision import working_precision
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.expression.pieces import jumps
from stickslip_sym.numerics.subdivide import MOST_INTERVALS, shown

BITS_OF_SIGNS = DOUBLE_BITS
"""The precision with which a sign is shown that is far from changing."""
_speed = sp.Symbol("v", positive=True)


def lipschitz_evidence(law: BoundLaw) -> tuple[bool, str]:
    """Return whether a law was shown to be locally Lipschitz for v > 0, and how, or what is against it."""
    for (start, segment), end in zip(law.segments, [*law.exact_kinks, law.end], strict=True):
        for argument in _must_be_positive(segment.xreplace({symbols.v: _speed})):
            if argument is None:
                return False, f"mu holds a function that is not analytic, in {segment}"
            if not _is_positive(argument.xreplace(law.point), start, end):
                where = f"between v = {start} and {end or 'infinity'}"
                return False, f"{argument} was not shown to be positive {where}"
    for place, height in jumps(law.expr, law.point):
        if height.xreplace(law.point) != 0 and sp.simplify(height) != 0:
            return False, f"mu jumps at v = {place}"
    if law.kinks:
        return True, f"mu is analytic on {len(law.segments)} segments of v > 0, which meet without a jump"
    return True, "mu is analytic for v > 0"


def _must_be_positive(expr: Expr) -> Iterator[Expr | None]:
    """Yield what has to be positive for an expression to be analytic; None for an unknown function."""
    for node in sp.preorder_traversal(expr):
        if not node.has(_speed) or node.is_Symbol:
            continue
        needed = must_be_positive(node)
        if needed is None and node.is_Pow and not node.exp.has(_speed):
            if not (node.exp.is_Integer and node.exp > 0):
                yield node.base**2 if node.exp.is_Integer else node.base
        else:
            yield from (None,) if needed is None else needed


def _is_positive(expr: Expr, start: Expr, end: Expr | None) -> bool:
    """Whether an expression of v is shown to be positive: by its signs, or by balls on a bounded range."""
    if expr.is_positive:
        return True
    if end is None:
        return False
    with working_precision(BITS_OF_SIGNS):
        function = ball_function(expr, _speed, {})

        def holds(low: Expr, high: Expr, _: int) -> bool:
            return bool(function(acb(ball(low).real.union(ball(high).real)), False).real > 0)

        return shown(holds, [(start, end)], halvings=math.inf, most=MOST_INTERVALS)
