"""The pure-slip threshold by simulation: the damping at which the slip from P grazes the belt's speed.

Nothing here knows a closed form, so the threshold is a check of every criterion. It is the needed damping of the
orbit with A = 1 (`needed`), for every law. Its derivatives follow from the same two halves: at the threshold the
gap is 0, so dzeta/dp = -(dgap/dp)/(dgap/dzeta) for every quantity p.
"""

import math

import sympy as sp

from stickslip_sym.core.errors import NotConverged
from stickslip_sym.model.expression.pieces import places
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.needed import by_zeta, gap, halves, needed_ratio
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.table import FrictionTable, Pieces

__all__ = ["grazing_damping", "grazing_sensitivity"]

_TIGHT = 1e-12  # tolerance of the steps along which the wedges are carried
_BEYOND = 1.5  # times the highest slip speed, up to which a derivative of the law is tabulated: steps try further
_SAME = 1e-12  # relative distance of two places of a kink that are one


def grazing_damping(law: FrictionLaw, osc: Oscillator, *, rtol: float, fast: bool = False) -> tuple[float, float]:
    """Return the damping c in kg/s at which the slip from P grazes the belt's speed, and its relative error.

    - `law`: with all parameters bound.
    - `osc`: its own c is not used.
    - `rtol`: relative error that is wanted.
    - `fast`: compiled where numba is there, for many dampings.

    The damping is negative where the slip does not return without any.

    Raises `InputError` for an unbound law, or one measured up to less than the motion reaches.
    Raises `NoThreshold` if the slip from P returns for every damping, or for none.
    Raises `NotConverged` when the bound on the work is reached.
    Raises `OutOfTime` when the time of a `time_limit` around it is up; it says between which dampings the
      threshold lies.
    """
    zeta, error, _ = needed_ratio(Dimensionless.of(law, osc), rtol=rtol, fast=fast)
    relative = 0.0 if error == 0.0 else error / abs(zeta) if zeta else math.inf
    return 2 * zeta * osc.impedance, relative


def grazing_sensitivity(law: FrictionLaw, osc: Oscillator) -> dict[str, float]:
    """Return dc/dp at the threshold for V, N, m, k and every parameter of the law.

    Raises as `grazing_damping`, and `NotConverged` where the halves do not meet within rounding.
    """
    system = Dimensionless.of(law, osc)
    zeta, _, _ = needed_ratio(system, rtol=_TIGHT)
    eta, V, push = system.eta, osc.V, system.push(1)
    excess = push / eta if eta else 0.0
    levels = list(system.rise.levels[: len(system.rise.jumps)])
    *_, highest = halves(system.rise, eta, zeta, push, 1.0, _TIGHT, False, 0.0, by_zeta(system))
    reach = _BEYOND * highest * V

    def derivative(constant: float, factor: float, pieces: Pieces, shifts: list[float]) -> float:
        """Return dc/dp for dw'/dp = constant + factor rise(w), where levels of the law shift by db/dp."""
        source = (constant, 0.0, factor, pieces, shifts)
        return -float(gap(system.rise, eta, zeta, push, 1.0, _TIGHT, True, 0.0, source)[1]) / slope * unit

    slope = float(gap(system.rise, eta, zeta, push, 1.0, _TIGHT, True, 0.0, by_zeta(system))[1])
    if not slope < 0.0:  # no number, or 0 where a half creeps to rest
        raise NotConverged(
            f"how the threshold changes is not known at eta = {eta:g} and V = {V:g} m/s: friction is so strong "
            "that the halves of the grazing orbit do not meet in double precision; try an average of the slope"
        )
    unit = 2 * osc.impedance
    still = [0.0] * len(levels)
    c = zeta * unit
    own = system.rise.pieces
    by_N = derivative(excess / (V * osc.impedance), -1 / (V * osc.impedance), own, still)
    by_impedance = (c - osc.N * by_N) / 2  # c/sqrt(k m) depends on N/sqrt(k m) alone
    found = {
        "V": derivative(-push / V, -eta / V, _stretched(own), [-level / V for level in levels]),
        "N": by_N,
        "m": by_impedance / osc.m,
        "k": by_impedance / osc.k,
    }
    for name, parameter in law.parameters.items():
        partial = FrictionTable.of(law.partial(name), reach)
        push_by = eta * (law.number(sp.diff(law.static_expr, parameter.symbol)) - partial.onset)
        shifts = _shifts(law, parameter.symbol, levels, V)
        found[name] = derivative(push_by, -eta, partial.at(V).pieces, shifts)
    return found


def _stretched(pieces: Pieces) -> list[tuple[float, ...]]:
    """Return the polynomials of w f'(w) - f(w) for those of f: how a rise over V changes with V, times V."""
    rows = []
    for low, origin, scale, *row in pieces:
        slope = [(k + 1) * c for k, c in enumerate(row[1:])] + [0.0]
        row = [origin * scale * s + (k - 1) * c for k, (s, c) in enumerate(zip(slope, row, strict=True))]
        rows.append((low, origin, scale, *row))
    return rows


def _shifts(law: FrictionLaw, symbol: sp.Symbol, levels: list[float], V: float) -> list[float]:
    """Return how the levels of w at which mu has a kink or jumps change with a parameter."""
    moves = {law.number(place): law.number(sp.diff(place, symbol)) for place in places(law.expr)}
    return [
        next((move / V for v, move in moves.items() if math.isclose(v, level * V, rel_tol=_SAME)), 0.0)
        for level in levels
    ]
