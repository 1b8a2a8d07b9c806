"""What was proved of a pure-slip threshold, in words and as LaTeX."""

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction

from stickslip_sym.core.aliases import Rational
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.box_transit import Transit
from stickslip_sym.output import printing
from stickslip_sym.output.layout import prose
from stickslip_sym.output.notation import latex_name

__all__ = ["Theorem"]


@dataclass(frozen=True)
class Theorem:
    """Two dampings that enclose the threshold, and what the statement rests on."""

    law: FrictionLaw
    scene: Mapping[str, Rational]  # V, N, m and k, and the law's parameters
    low: Fraction  # a damping in kg/s at which the slip from P returns
    high: Fraction  # one at which it does not
    below: Transit  # the slip from P at `low`
    above: Transit  # and at `high`
    undamped: Transit | None
    """The slip at c = 0, where it was shown to return. Then all slips for c >= 0 lie inside it; otherwise the
    statement is for c >= `low` only."""
    hypotheses: tuple[tuple[str, str], ...]  # what the lemma needs of the law, and how that was checked

    @property
    def enclosure(self) -> Enclosure:
        """The threshold, between both dampings."""
        return Enclosure(self.low, self.high)

    @property
    def statement(self) -> str:
        """The theorem, in one sentence."""
        returns = f"at c = {decimal(self.low)} kg/s"
        if self.undamped is not None:
            returns = f"for every c from 0 to {decimal(self.low)} kg/s"
        misses = f"for no c of {decimal(self.high)} kg/s or more"
        return f"The slip that leaves P returns to the belt's speed {returns}, and {misses}."

    @property
    def proof(self) -> list[str]:
        """What was checked and computed, a sentence each."""
        lines = [f"{what}: {how}" for what, how in self.hypotheses]
        if self.undamped is not None:
            reach = float(self.undamped.highest.upper())
            lines.append(f"without damping the slip returns, {_work(self.undamped)}")
            lines.append(
                f"so all slips with damping lie inside it, at slip speeds below {reach:.4g} times the belt's"
            )
        for c, transit in ((self.low, self.below), (self.high, self.above)):
            end = "returns" if transit.returns else "turns at a slip speed above 0, and does not return"
            lines.append(f"at c = {decimal(c)} kg/s the slip {end}, {_work(transit)}")
        lines.append(
            "what returns at one damping returns at every smaller one, since more damping turns the field one way"
        )
        return lines

    def __str__(self) -> str:
        values = ", ".join(f"{name} = {value}" for name, value in self.scene.items())
        head = f"Theorem. Let mu(v) = {self.law.text}, with {values} in SI units. {self.statement}"
        return "\n".join([head, "Proof.", *(f"- {line}." for line in self.proof)])

    def latex(self) -> str:
        """Return the theorem and its proof as LaTeX paragraphs."""
        values = ", ".join(f"${latex_name(name)} = {value}$" for name, value in self.scene.items())
        mu = (
            prose(self.law.text)
            if self.law.curve is not None
            else f"${printing.latex(self.law.expr, inline=True)}$"
        )
        names = {name: name for name in ("P", "c")}
        items = "\n".join(f"  \\item {prose(line, names)}." for line in self.proof)
        theorem = f"Let $\\mu(v)$ be {mu}, with {values} in SI units. {prose(self.statement, names)}"
        proof = f"\\begin{{itemize}}\n{items}\n\\end{{itemize}}"
        return f"\\paragraph{{Theorem.}} {theorem}\n\\paragraph{{Proof.}}\n{proof}\n"


def decimal(value: Fraction) -> str:
    """Return a fraction whose denominator divides a power of ten as a decimal number, exactly."""
    with localcontext(prec=10_000):
        return f"{Decimal(value.numerator) / Decimal(value.denominator):f}"


def _work(transit: Transit) -> str:
    return f"by {transit.steps} Taylor steps with {transit.bits} bits, in boxes no wider than {transit.width:.1e}"
