"""What the lemma on thresholds needs of a friction law, checked: mu is locally Lipschitz for v > 0.

The nodes of a formula are analytic functions but for a few: a fraction at a zero of its denominator, a root or a
logarithm where its argument is not positive, a tangent at its poles. So it is enough to show that each of these
arguments is positive for v > 0, and that segments of mu meet without a jump.
"""

from collections.abc import Iterator
from itertools import pairwise

import sympy as sp
from flint import acb

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.balls import ball, ball_function, ball_value, working_precision
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import is_analytic
from stickslip_sym.model.expression.pieces import branch_from, jumps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.box_scene import BoxScene

__all__ = ["checked_hypotheses", "lipschitz_evidence"]

_BITS = 64
_MOST_CUTS = 400  # of a range on which a sign is shown
_speed = sp.Symbol("v", positive=True)


def checked_hypotheses(scene: BoxScene) -> tuple[tuple[str, str], ...]:
    """Return what the lemma needs, and how it was checked for a law and its static coefficient.

    Raises `InputError` if a hypothesis was not shown; the message says which, and why.
    """
    smooth, how = lipschitz_evidence(scene.law)
    if not smooth:
        raise InputError(f"a threshold is proved for laws that are locally Lipschitz for v > 0, and {how}; "
                         'try method="simulation", which takes all laws')  # fmt: skip
    found = [("mu is locally Lipschitz for v > 0", how)]
    if scene.law.static is None:
        return (*found, ("the static coefficient is mu(0+)", "the law has no other"))
    with working_precision(_BITS):
        above = scene.static - scene.at_rest
        if not ball_value(above, scene.point).real > 0 and above.xreplace(scene.point) != 0:
            raise InputError("the static coefficient was not shown to be at least mu(0+), as a proof needs it")
    return (*found, ("the static coefficient is at least mu(0+)", "by enclosing both"))


def lipschitz_evidence(law: FrictionLaw) -> tuple[bool, str]:
    """Return whether mu was shown to be locally Lipschitz for v > 0, and how, or what stands against it.

    - `law`: with all parameters bound.
    """
    point = {law.parameters[name].symbol: value for name, value in law.values.items()}
    kinks = law.kinks()
    ends = [sp.Integer(0), *kinks, law.v_max]
    for start, end in pairwise(ends):
        segment = branch_from(law.expr, point, start)
        for argument in _must_be_positive(segment.xreplace({symbols.v: _speed})):
            if argument is None:
                return False, f"mu holds a function that is not analytic, in {segment}"
            if not _is_positive(argument.xreplace(point), start, end):
                return (
                    False,
                    f"{argument} was not shown to be positive between v = {start} and {end or 'infinity'}",
                )
    for place, height in jumps(law.expr):
        if height.xreplace(point) != 0 and sp.simplify(height) != 0:
            return False, f"mu jumps at v = {place}"
    if kinks:
        return True, f"mu is analytic on {len(kinks) + 1} segments of v > 0, which meet without a jump"
    return True, "mu is analytic for v > 0"


def _must_be_positive(expr: Expr) -> Iterator[Expr | None]:
    """Yield what has to be positive for an expression to be analytic; None for an unknown function."""
    for node in sp.preorder_traversal(expr):
        if not node.has(_speed) or node.is_Symbol or is_analytic(node):
            continue
        if node.is_Pow:
            if node.exp.has(_speed):
                yield None
            elif not (node.exp.is_Integer and node.exp > 0):
                yield node.base**2 if node.exp.is_Integer else node.base
        elif isinstance(node, sp.log):
            yield node.args[0]
        else:
            yield None


def _is_positive(expr: Expr, start: Rational, end: Rational | None) -> bool:
    """Whether an expression of v is shown to be positive: by its signs, or by balls on a bounded range."""
    if expr.is_positive:
        return True
    if end is None:
        return False
    with working_precision(_BITS):
        function = ball_function(expr, _speed, {})
        waiting = [(start, end)]
        for _ in range(_MOST_CUTS):
            if not waiting:
                return True
            low, high = waiting.pop()
            if not function(acb(ball(low).real.union(ball(high).real)), False).real > 0:
                waiting += [(low, (low + high) / 2), ((low + high) / 2, high)]
    return False
