"""How the end of a slip from P changes with the quantities: the variational equation along the motion.

With y = (q, w) and y' = f(y; p), the change Y = dy/dp obeys Y' = A Y + B with A = df/dy and B = df/dp. It is
integrated over each step of the simulated slip by Radau's collocation of order 11, which fast decays do not
trouble. Where mu jumps at a slip speed b, w' jumps from f- to f+, and dw/dp from dw to
dw + (f- - f+)(db/dp - dw)/f-; where the mass slides there, dw/dp = db/dp.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp
from scipy.special import roots_jacobi

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.model.coefficient import Coefficient
from stickslip_sym.model.expression.pieces import branch_from, places
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.simulation import engines
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.motion.simulation.transit import horizon

__all__ = ["grazing_variation"]

_RTOL = 1e-13
_STAGES = 6
_NEAREST = 1e-300  # slip speed over the belt's, where mu may have no slope at 0


def grazing_variation(law: FrictionLaw, osc: Oscillator) -> dict[str, float]:
    """Return the derivatives of the lowest slip speed w after the slip from P, at the threshold.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
        With the damping at which the slip from P just grazes w = 0.

    Returns
    -------
    dict of str to float
        By "c", "V", "N", "m", "k" and each parameter of the law. At the threshold dc/dp = -(dw/dp)/(dw/dc).

    Raises
    ------
    NotConverged
        When the bound on the work is reached.
    """
    scene = Scene.of(law, osc)
    slip = follow(
        scene, Point(0.0, 0.0, 0.0), 1, horizon=horizon(scene), rtol=_RTOL, until=End.MINIMUM,
        engine=engines.find("scipy"),
    )  # fmt: skip
    branches = _branches(law, osc)
    names = ["c", "V", "N", "m", "k", *law.parameters]
    Y: FloatArray = np.zeros((2, len(names)))
    walk = _Walk(scene, osc, branches, names)
    number = 0
    for piece, (start, end) in zip(slip.interpolants, pairwise(slip.points), strict=True):
        middle = float(piece((start.tau + end.tau) / 2)[1])
        if start.w == middle == end.w and any(start.w == branch.low for branch in branches[1:]):
            walk.slide(Y, start, end)
            continue
        entered = max(i for i, branch in enumerate(branches) if i == 0 or branch.low <= middle)
        if entered != number:
            walk.cross(Y, start, number, entered)
            number = entered
        Y = walk.step(Y, piece, start, end, number)
    _to_the_minimum(walk, Y, slip, number)
    return dict(zip(names, Y[1].tolist(), strict=True))


@dataclass(frozen=True)
class _Branch:
    """A smooth piece of mu: where it begins as w, how that changes, and its functions of v."""

    low: float
    shift: Mapping[str, float]
    mu: Callable[[Any], Any]
    slope: Callable[[Any], Any]
    partials: Mapping[str, Callable[[Any], Any]]


def _branches(law: FrictionLaw, osc: Oscillator) -> list[_Branch]:
    values = {law.parameters[name].symbol: value for name, value in law.values.items()}
    found = []
    known = {place: place.xreplace(values) for place in places(law.expr)}
    for start in (sp.Integer(0), *law.kinks()):
        expr = branch_from(law.expr, values, start)

        def function(expr: Expr = expr) -> Callable[[Any], Any]:
            free = sorted(expr.free_symbols - {symbols.v}, key=str)
            return Coefficient(expr, free).function(values, "numpy")

        shift = {"V": -float(start) / osc.V**2}
        place = next((place for place, value in known.items() if value == start), sp.Integer(0))
        for name, parameter in law.parameters.items():
            shift[name] = float(sp.diff(place, parameter.symbol).xreplace(values)) / osc.V
        partials = {n: function(sp.diff(expr, p.symbol)) for n, p in law.parameters.items()}
        found.append(
            _Branch(float(start) / osc.V, shift, function(), function(sp.diff(expr, symbols.v)), partials)
        )
    return found


class _Walk:
    """The variation along one slip."""

    def __init__(self, scene: Scene, osc: Oscillator, branches: list[_Branch], names: list[str]) -> None:
        self.scene, self.osc, self.branches, self.names = scene, osc, branches, names
        law = scene.law
        static = law.static_expr
        self.static = {
            name: float(law.substitute(sp.diff(static, parameter.symbol)))
            for name, parameter in law.parameters.items()
        }

    def rates(self, q: FloatArray, w: FloatArray, number: int) -> tuple[FloatArray, FloatArray]:
        """Return A and B at states on a piece of mu."""
        osc, branch, scene = self.osc, self.branches[number], self.scene
        w = np.maximum(w, _NEAREST)
        v, impedance = osc.V * w, osc.impedance
        with np.errstate(all="ignore"):
            slope = np.broadcast_to(branch.slope(v), v.shape)
            fall = scene.static - branch.mu(v)
        eta = scene.eta
        by_impedance = -eta / impedance * fall + osc.c / impedance**2 * w
        push = {
            "c": -w / impedance,
            "V": -eta / osc.V * fall - eta * slope * w,
            "N": fall / (osc.V * impedance),
            "m": by_impedance * impedance / (2 * osc.m),
            "k": by_impedance * impedance / (2 * osc.k),
        }
        for name, partial in branch.partials.items():
            with np.errstate(all="ignore"):
                push[name] = eta * (self.static[name] - partial(v))
        A = np.zeros((len(v), 2, 2))
        A[:, 0, 1], A[:, 1, 0], A[:, 1, 1] = -1.0, 1.0, -(eta * osc.V * slope + 2 * scene.zeta)
        B = np.zeros((len(v), 2, len(self.names)))
        for column, name in enumerate(self.names):
            B[:, 1, column] = push[name]
        return A, B

    def step(self, Y: FloatArray, piece: Any, start: Point, end: Point, number: int) -> FloatArray:
        """Return the variation at the end of a step."""
        nodes, weights = _radau()
        h = end.tau - start.tau
        if h <= 0:
            return Y
        q, w = piece(start.tau + h * nodes)
        A, B = self.rates(q, w, number)
        matrix = np.eye(2 * _STAGES) - h * (weights[:, None, :, None] * A.transpose(1, 0, 2)[None]).reshape(
            2 * _STAGES, 2 * _STAGES
        )
        right = np.tile(Y, (_STAGES, 1)) + h * np.einsum("ij,jab->iab", weights, B).reshape(2 * _STAGES, -1)
        return np.linalg.solve(matrix, right)[-2:]

    def cross(self, Y: FloatArray, now: Point, number: int, entered: int) -> None:
        """Pass from one piece of mu to the next."""
        before, after = (self._rate(now, one) for one in (number, entered))
        if before:
            Y[1] += (before - after) * (self._level(max(number, entered)) - Y[1]) / before

    def slide(self, Y: FloatArray, start: Point, end: Point) -> None:
        """Slide at the slip speed of a jump: w is held there, and q' = 1 - w."""
        number = next(i for i, branch in enumerate(self.branches) if branch.low == start.w)
        Y[1] = self._level(number)
        Y[0] -= (end.tau - start.tau) * Y[1]

    def _rate(self, now: Point, number: int) -> float:
        mu = float(self.branches[number].mu(self.osc.V * now.w))
        return self.scene.eta * (self.scene.static - mu) + now.q - 2 * self.scene.zeta * now.w

    def _level(self, number: int) -> FloatArray:
        shift = self.branches[number].shift
        return np.array([shift.get(name, 0.0) for name in self.names])


def _to_the_minimum(walk: _Walk, Y: FloatArray, slip: SlipPhase, number: int) -> None:
    """Go on from a return, just before the minimum that a threshold has at w = 0, where w'' = 1."""
    last = slip.last
    if slip.end is End.RETURN:
        A, B = walk.rates(np.array([last.q]), np.array([last.w]), number)
        time = -walk.scene.acceleration(last.q, 0.0, 1)
        change = time * (A[0] @ Y + B[0])[1]
        if np.isfinite(change).all() and math.isfinite(time):
            Y[1] += change


@cache
def _radau() -> tuple[FloatArray, FloatArray]:
    """Return the nodes of Radau's collocation on [0, 1], the last one 1, and its integration weights."""
    inner, _ = roots_jacobi(_STAGES - 1, 1.0, 0.0)
    nodes = np.append((1 + inner) / 2, 1.0)
    powers = np.arange(_STAGES)
    vandermonde = nodes[:, None] ** powers
    integrals = nodes[:, None] ** (powers + 1) / (powers + 1)
    return nodes, integrals @ np.linalg.inv(vandermonde)
