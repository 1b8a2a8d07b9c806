"""A law and an oscillator in exact numbers, and its field in balls, segment by segment of mu."""

from dataclasses import dataclass

import sympy as sp
from flint import arb

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.balls import ball, ball_function, series_function
from stickslip_sym.model.expression.pieces import branch_from
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.taylor_boxes import Field

__all__ = ["BoxScene", "Segment"]

_W = sp.Symbol("w")


@dataclass(frozen=True)
class BoxScene:
    """A law and an oscillator without damping, in exact numbers."""

    law: FrictionLaw  # bound
    V: Rational
    N: Rational
    m: Rational
    k: Rational  # all four in SI units

    @property
    def point(self) -> dict[Expr, Rational]:
        """Return the values of the law's parameters."""
        return {self.law.parameters[name].symbol: value for name, value in self.law.values.items()}

    @property
    def values(self) -> dict[str, Rational]:
        """Return all that was given, by name."""
        return {"V": self.V, "N": self.N, "m": self.m, "k": self.k, **self.law.values}

    @property
    def at_rest(self) -> Expr:
        """The coefficient mu(0+), by the first segment at v = 0."""
        return branch_from(self.law.expr, self.point, sp.Integer(0)).xreplace({symbols.v: sp.Integer(0)})

    @property
    def static(self) -> Expr:
        """The coefficient that limits sticking."""
        return self.at_rest if self.law.static is None else self.law.static

    def segments(self, c: Rational) -> list["Segment"]:
        """Return the smooth segments of the field, ascending, at the working precision."""
        point, law, static = self.point, self.law, self.static
        starts = [sp.Integer(0), *law.kinks()]
        ends = [*starts[1:], law.v_max]
        impedance = sp.sqrt(self.k * self.m)
        found = []
        for start, end in zip(starts, ends, strict=True):
            mu = branch_from(law.expr, point, start).xreplace({symbols.v: self.V * _W})
            push = self.N / (self.V * impedance) * (static - mu) - c / impedance * _W
            field = Field(
                ball_function(push, _W, point),
                series_function(push, _W, point),
                series_function(sp.diff(push, _W), _W, point),
            )
            found.append(
                Segment(ball(start / self.V).real, None if end is None else ball(end / self.V).real, field)
            )
        return found

    @property
    def starts_gently(self) -> bool:
        """Whether w' = 0 at P exactly: no static coefficient above mu(0+)."""
        return self.law.static is None


@dataclass(frozen=True)
class Segment:
    """The field between two slip speeds over V; the last one has no end unless the law has."""

    low: arb
    high: arb | None
    field: Field
