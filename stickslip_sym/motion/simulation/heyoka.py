"""Friction laws compiled by heyoka: integrators of slip, with the extrema of the slip speed as their events."""

from functools import lru_cache
from threading import local
from types import ModuleType
from typing import TYPE_CHECKING, cast

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.oscillator import Scene

if TYPE_CHECKING:
    from heyoka import expression, taylor_adaptive

__all__ = ["EXTREMUM", "OTHERWISE", "integrator_of"]

EXTREMUM = -1
"""The number by which heyoka names its first terminal event."""
OTHERWISE = 'use engine="scipy"'
_MOST_COMPILED = 32  # laws whose integrators are kept
_OWN = 5  # runtime parameters of the oscillator, before those of the law


def integrator_of(scene: Scene, side: int) -> "taylor_adaptive":
    """Return the compiled integrator of a scene's law with the scene's numbers in it."""
    law = scene.law
    # A power of 0 has a Taylor series only if its exponent is known to be whole.
    symbols_of = {name: parameter.symbol for name, parameter in law.parameters.items()}
    whole = {
        symbol: law.values[name]
        for name, symbol in symbols_of.items()
        if law.values[name].is_Integer and symbol in _exponents(law.expr)
    }
    names = [name for name, symbol in symbols_of.items() if symbol not in whole]
    integrator = _compiled.of(law.expr.xreplace(whole), tuple(symbols_of[name] for name in names))
    values = scene.eta, scene.zeta, scene.static, side, scene.speed, *(float(law.values[name]) for name in names)
    integrator.pars[:] = values[: len(integrator.pars)]  # a constant law has no use for the last ones
    integrator.state[:] = 0.0
    integrator.step(0.0, write_tc=True)
    if not np.isfinite(integrator.tc).all():
        raise InputError(f"{law!r} has no Taylor series at the slip speed 0; {OTHERWISE}")
    integrator.reset_cooldowns()  # an event of the last phase must not hide one of the next
    return integrator


@lru_cache
def _exponents(expr: Expr) -> frozenset[Expr]:
    """Return the symbols in exponents of v."""
    powers = [power for power in expr.atoms(sp.Pow) if power.base.has(symbols.v)]
    return frozenset().union(*(power.exp.free_symbols for power in powers))


def _compile(expr: Expr, parameters: tuple[Expr, ...]) -> "taylor_adaptive":
    heyoka = _heyoka()
    q, w = heyoka.make_vars("q", "w")
    eta, zeta, static, side, speed = (heyoka.par[i] for i in range(_OWN))
    leaves = {symbol: heyoka.par[_OWN + i] for i, symbol in enumerate(parameters)}
    mu = _translated(expr, leaves | {symbols.v: speed * w}, heyoka)
    rate = eta * (side * static - mu) + side * q - 2.0 * zeta * w
    return heyoka.taylor_adaptive(
        [(q, 1.0 - side * w), (w, rate)], [0.0, 0.0], t_events=[heyoka.t_event(rate)], compact_mode=True
    )


class _Compiled(local):
    """Integrators by law. They hold a state, so each thread has its own."""

    def __init__(self) -> None:
        self.of = lru_cache(_MOST_COMPILED)(_compile)


_compiled = _Compiled()


def _heyoka() -> ModuleType:
    try:
        import heyoka
    except ImportError:
        raise InputError(
            f"engine=\"heyoka\" needs the package heyoka: pip install 'stickslip_sym[fast]', or {OTHERWISE}"
        ) from None
    heyoka.set_logger_level_error()  # it warns of values that are not finite, which here are exceptions
    return cast(ModuleType, heyoka)


_FUNCTIONS = frozenset({"exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asinh", "atan", "erf"})
"""What heyoka has by the same name."""


def _translated(expr: Expr, leaves: "dict[Expr, expression]", heyoka: ModuleType) -> "expression":
    """Return a SymPy expression as heyoka's."""
    if expr in leaves:
        return leaves[expr]
    if not expr.free_symbols:
        return heyoka.expression(float(expr))
    name = type(expr).__name__
    if isinstance(expr, sp.Piecewise) or name not in _FUNCTIONS | {"Add", "Mul", "Pow", "sech"}:
        raise InputError(
            f'engine="heyoka" needs a law that is smooth and known to heyoka, got {name}; {OTHERWISE}'
        )
    arguments = [_translated(argument, leaves, heyoka) for argument in expr.args]
    if isinstance(expr, sp.Add):
        return heyoka.sum(arguments)
    if isinstance(expr, sp.Mul):
        return heyoka.prod(arguments)
    if isinstance(expr, sp.Pow):
        whole = expr.exp.is_Integer and expr.exp > 0
        return _power(arguments[0], int(expr.exp)) if whole else arguments[0] ** arguments[1]
    return 1.0 / heyoka.cosh(*arguments) if name == "sech" else getattr(heyoka, name)(*arguments)


def _power(base: "expression", exponent: int) -> "expression":
    """Return a power by products: heyoka's own series of a power, but for squares, divides by its base."""
    if exponent == 1:
        return base
    half = _power(base, exponent // 2)
    return half * half * base if exponent % 2 else half * half
