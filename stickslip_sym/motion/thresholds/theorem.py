"""A pure-slip threshold as a theorem: two dampings, close together, at which the slip from P is decided.

More damping turns the field one way and moves P inwards (the chapter `one_threshold` of the derivations), so if
the slip from P returns at one damping it does so at every smaller one. One damping at which it returns and one
at which it does not enclose the threshold. Critical values of other quantities are enclosed by the same search.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import partial

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Rational
from stickslip_sym.core.balls import ball_value
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold
from stickslip_sym.core.precision import GUARD_BITS, working_precision
from stickslip_sym.core.remedies import Argument
from stickslip_sym.criteria.enclosure import Enclosure, enclosure_of
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.lipschitz import BITS_OF_SIGNS, lipschitz_evidence
from stickslip_sym.motion.thresholds.boxes import ExactPoint, Transit, Undecided, transit
from stickslip_sym.motion.thresholds.operating_points import VANISHING
from stickslip_sym.output import printing
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.layout import prose_latex
from stickslip_sym.output.notation import latex_name

_MOST_BITS_BEYOND_DISTANCE = 600  # of a decision, beyond those of its distance from the threshold
_FIRST_BRACKET = 1e-2  # of the first bracket, relative


@dataclass(frozen=True)
class Theorem(DataResult):
    """Two dampings that enclose the threshold, and what the statement rests on.

    Attributes
    ----------
    law : FrictionLaw
    values : mapping of str to Rational
        V, N, m and k, and the law's parameters.
    low, high : fractions.Fraction
        Dampings in kg/s at which the slip that follows stick returns, and at which it does not.
    below, above : Transit
        The slip that follows stick, at these.
    undamped : Transit or None
        The slip at c = 0, where it was shown to return. Then all slips for c >= 0 lie inside it; otherwise the
        statement is for c >= `low` only.
    hypotheses : tuple of (str, str)
        What the lemma needs of the law, and how that was checked.
    """

    law: FrictionLaw
    values: Mapping[str, Rational]
    low: Fraction
    high: Fraction
    below: Transit
    above: Transit
    undamped: Transit | None
    hypotheses: tuple[tuple[str, str], ...]

    @property
    def enclosure(self) -> Enclosure:
        """The threshold, between both dampings."""
        return Enclosure(self.low, self.high)

    @property
    def statement(self) -> str:
        """The theorem, in one sentence."""
        returns = f"at c = {_exact_decimal(self.low)} kg/s"
        if self.undamped is not None:
            returns = f"for every c from 0 to {_exact_decimal(self.low)} kg/s"
        misses = f"for no c of {_exact_decimal(self.high)} kg/s or more"
        return f"The slip that follows stick returns to the belt's speed {returns}, and {misses}."

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
        for c, decided in ((self.low, self.below), (self.high, self.above)):
            end = "returns" if decided.returns else "turns at a slip speed above 0, and does not return"
            lines.append(f"at c = {_exact_decimal(c)} kg/s the slip {end}, {_work(decided)}")
        lines.append(
            "what returns at one damping returns at every smaller one, since more damping turns the field one way"
        )
        return lines

    def __str__(self) -> str:
        values = ", ".join(f"{name} = {value}" for name, value in self.values.items())
        head = f"Theorem. Let mu(v) = {self.law.text}, with {values} in SI units. {self.statement}"
        return "\n".join([head, "Proof.", *(f"- {line}." for line in self.proof)])

    def certificate(self) -> str:
        """Return a Python script that proves the theorem by itself, in python-flint and without this package."""
        from stickslip_sym.certificates.thresholds import certificate_of_threshold

        point = ExactPoint(self.law, *(self.values[name] for name in ("V", "N", "m", "k")))
        transits = [self.below, self.above, *([] if self.undamped is None else [self.undamped])]
        bits = max(transit.bits for transit in transits)
        conditions = [f"{what}: {how}" for what, how in self.hypotheses]
        ends = self.low, self.high
        is_undamped = self.undamped is not None
        return certificate_of_threshold(point, ends, bits, is_undamped, self.statement, conditions)

    def latex(self) -> str:
        """Return the theorem and its proof as LaTeX paragraphs."""
        values = ", ".join(f"${latex_name(name)} = {value}$" for name, value in self.values.items())
        formula = self.law.curve is None
        if formula:
            mu = f"${printing.latex(self.law.expr, inline=True)}$"
        else:
            mu = prose_latex(self.law.text)
        names = {name: name for name in ("P", "c")}
        items = "\n".join(f"  \\item {prose_latex(line, names)}." for line in self.proof)
        theorem = f"Let $\\mu(v)$ be {mu}, with {values} in SI units. {prose_latex(self.statement, names)}"
        proof = f"\\begin{{itemize}}\n{items}\n\\end{{itemize}}"
        return f"\\paragraph{{Theorem.}} {theorem}\n\\paragraph{{Proof.}}\n{proof}\n"


def _exact_decimal(value: Fraction) -> str:
    """Return a fraction whose denominator divides a power of ten as a decimal number, exactly."""
    with localcontext(prec=10_000):
        return f"{Decimal(value.numerator) / Decimal(value.denominator):f}"


def _work(transit: Transit) -> str:
    return f"by {transit.steps} Taylor steps with {transit.bits} bits, in boxes no wider than {transit.width:.1e}"


def prove_threshold(point: ExactPoint, guess: float, error: float, rtol: float, scale: float = 0.0) -> Theorem:
    """Prove two dampings that enclose the threshold.

    - `guess, error`: a value of the threshold in kg/s, and its relative error as far as known.
    - `rtol`: the width of the enclosure, relative.
    - `scale`: N <|mu'|>; both are relative to a small part of that where the guess lies below.

    Raises `InputError` if the law does not meet a hypothesis of the lemma.
    Raises `NoThreshold` if the slip returns for no damping c >= 0.
    Raises `NotConverged` if a decision does not fall; it says where the boxes grew.
    """
    hypotheses = checked_hypotheses(point)
    if guess == 0 and not scale and point.law.expr.has(symbols.v):
        raise NotConverged(
            "in double precision the threshold was not distinguished from 0, near which nothing is enclosed"
        )
    if guess == scale == 0:
        raise NoThreshold("the threshold is 0: friction does no work on a round, and nothing is left to enclose")
    search = Search(partial(transit, point), "c in kg/s")
    enclosure = search.around(guess, error, rtol, scale)
    undamped = None
    if enclosure.low > 0:
        with suppress(Undecided, InputError):
            undamped = transit(point, Fraction(0), BITS_OF_SIGNS)
    if undamped is not None and not undamped.returns:
        raise NoThreshold("the slip returns at some damping, but not without any: the lemma does not hold here")
    below = search.decided[enclosure.low]
    above = search.decided[enclosure.high]
    return Theorem(point.law, point.values, enclosure.low, enclosure.high, below, above, undamped, hypotheses)


# -- the search ------------------------------------------------------------------------------------


class Search:
    """Decisions at values of the damping, or of minus it, or of another quantity; and what encloses the threshold.

    - `decision`: from a value, and bits of precision, to the `Transit` there.
    - `label`: what the value is, for messages.
    """

    def __init__(self, decision: Callable[[Fraction, int], Transit], label: str) -> None:
        self.decision = decision
        self.label = label
        self.decided: dict[Fraction, Transit] = {}
        self.bits = GUARD_BITS

    def around(self, value: float, error: float, rtol: float, scale: float = 0.0) -> Enclosure:
        """Enclose the threshold by two values within a relative distance.

        - `value, error`: where to look, and its relative error as far as known.
        - `scale`: size of what cancels in a value close to 0; distances are relative to a small part of it then.
        """
        center = Fraction(value)
        close = Fraction(rtol)
        least = Fraction(VANISHING * scale)
        base = max(abs(center), least)
        size = max(abs(center), Fraction(scale))
        half = close * base * Fraction(2, 5)
        width = max(half, base * Fraction(min(max(2 * error, 1e-15), _FIRST_BRACKET)))
        for side in (-1, 1):  # the slip returns below the threshold
            step = width
            while self._returns(_rounded(center + side * step, step), step / size) != (side < 0):
                step *= 4
                center = self._secant() or center  # a guess that is off by more than it says is mended
                if not 0 < step < max(abs(center), size):
                    raise NotConverged(f"no change is near the guess {self.label} = {float(abs(center)):g}")
        while True:
            low = max(x for x, transit in self.decided.items() if transit.returns)
            high = min(x for x, transit in self.decided.items() if not transit.returns)
            if low > high:
                raise NotConverged(f"several changes are near the guess {self.label} = {float(abs(center)):g}")
            if high - low <= close * max(abs(low), least):
                return Enclosure(low, high)
            # By the secant where it converges, else by halves.
            middle = self._secant()
            radius = max(half, (high - low) ** 2 / size)
            if middle is None or not low < middle < high or radius > (high - low) / 4:
                middle = (low + high) / 2
                radius = Fraction(0)
            grain = radius or (high - low) / 8
            for x in sorted({_rounded(middle + side * radius, grain) for side in (-1, 1)}):
                if low < x < high and not self._returns(x, grain / size):
                    break  # nor does it beyond

    def _returns(self, x: Fraction, distance: Fraction) -> bool:
        """Decide at a value, at a precision that suits its relative distance from the threshold."""
        close = int(1.25 * max(0.0, -math.log2(distance)))
        while x not in self.decided:
            bits = self.bits + close
            try:
                self.decided[x] = self.decision(x, bits)
            except Undecided as error:
                if self.bits > _MOST_BITS_BEYOND_DISTANCE:
                    where = f"{self.label} = {float(abs(x)):.15g} with {bits} bits"
                    raise NotConverged(f"undecided at {where}: {error}") from None
                self.bits *= 2  # nor would fewer do at the next value
        return self.decided[x].returns

    def _secant(self) -> Fraction | None:
        """Return where the lowest slip speed vanishes by the secant through two decisions close to it."""
        lowest = [
            (abs(transit.lowest.mid()), x, transit.lowest.mid())
            for x, transit in self.decided.items()
            if transit.turned
        ]
        lowest.sort(key=lambda row: float(row[0]))
        if len(lowest) < 2 or lowest[0][2] == lowest[1][2]:
            return None
        (_, x, w), (_, x_2, w_2) = lowest[:2]
        return x - (x_2 - x) * enclosure_of((w / (w_2 - w)).mid()).mid


def _rounded(x: Fraction, width: Fraction) -> Fraction:
    """Return the nearest decimal number with one more digit than a width calls for."""
    places = max(0, math.ceil(1 - math.log10(width)))
    return Fraction(round(x * 10**places), 10**places)


# -- hypotheses ------------------------------------------------------------------------------------


def checked_hypotheses(point: ExactPoint) -> tuple[tuple[str, str], ...]:
    """Return what the lemma needs, and how it was checked for a law and its static coefficient.

    Raises `InputError` if a hypothesis was not shown; the message says which, and why.
    """
    law = point.law
    smooth, how = lipschitz_evidence(law.bound)
    if not smooth:
        raise InputError(f"a threshold is proved for laws that are locally Lipschitz for v > 0, and {how}; try ",
                         Argument("method", "simulation"), ", which takes all laws")  # fmt: skip
    lipschitz = ("mu is locally Lipschitz for v > 0", how)
    if law.static is None:
        return (lipschitz, ("the static coefficient is mu(0+)", "the law has no other"))
    with working_precision(BITS_OF_SIGNS):
        above = law.static - point.at_rest
        if not ball_value(above, law.point).real > 0 and above.xreplace(law.point) != 0:
            raise InputError("the static coefficient was not shown to be at least mu(0+), as a proof needs it")
    return (lipschitz, ("the static coefficient is at least mu(0+)", "by enclosing both"))
