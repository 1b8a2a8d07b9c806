"""`Decision`: whether the damping is below the threshold, and all that is said of it, by one object."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import Span
from stickslip_sym.core.probabilities import UNLIKELY, USUAL_PROBABILITY, VERY_UNLIKELY
from stickslip_sym.core.uncertain import interval_text, text_with_error
from stickslip_sym.model.fitting.averaged import Averaged
from stickslip_sym.model.fitting.weights import RANKED
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output.data import DataResult

_FEWEST_SPEEDS = 5  # speeds, below which the range of the threshold is stated, and no decision
_AVERAGED = 6  # speeds, from which the average over laws decides, and not all laws together
_NODES, _SHARES = np.polynomial.legendre.leggauss(24)  # friction is smooth there, but for a power of v


@dataclass(frozen=True)
class Decision(DataResult):
    """Whether the damping c is below the pure-slip damping: every word and number that is stated of it.

    Where the law was fitted, the fits decide: by the average over the laws that may be meant, and by all of them
    where the measured speeds are fewer than six; below five no decision is stated.

    Attributes
    ----------
    c, c_error : float
        In kg/s; the standard error is 0 where c carries none.
    value : float
        The pure-slip damping, averaged over the laws that may be meant.
    standard_error : float
        Its standard error, 0 where nothing carries one.
    chance : float or None
        The probability that c is below the pure-slip damping, None where nothing carries a standard error.
    by_law : (float, float) or None
        The least and the greatest of this probability by each law; None where the law was not fitted.
    averaged : Averaged or None
        The pure-slip damping by every law; None where the law was not fitted.
    """

    reported = ("below", "probability", "value", "standard_error", "range", "statement", "if_friction_builds_up")

    c: float
    c_error: float
    value: float
    standard_error: float
    chance: float | None = None
    by_law: Span | None = None
    averaged: Averaged | None = None

    @classmethod
    def of_measured(cls, c: float, c_error: float, averaged: Averaged) -> Decision:
        """Return what the fits of laws to measurements decide."""
        if averaged.dof <= 0:
            return cls(c, c_error, averaged.value, averaged.standard_error, averaged=averaged)
        each = averaged.above_by_law(c, c_error)
        chance = averaged.above(c, c_error)
        least = float(each.min())
        most = float(each.max())
        return cls(c, c_error, averaged.value, averaged.standard_error, chance, (least, most), averaged)

    @property
    def _speeds(self) -> float:
        return math.inf if self.averaged is None else self.averaged.speeds

    @property
    def few(self) -> bool:
        """Whether too few speeds were measured to rank laws, so that a range stands for the average."""
        return self._speeds < RANKED

    @property
    def _possible(self) -> Span | None:
        """The least and the greatest probability that c is below, by what decides; None if nothing does."""
        if self.averaged is None or self.chance is None:
            return None
        if self._speeds < _AVERAGED:
            least, most = self.by_law or (0.0, 1.0)
        else:
            least = most = self.chance
        known = 1 - self.averaged.unknown  # laws without a threshold may say anything
        return known * least, known * most + self.averaged.unknown

    @property
    def below(self) -> bool | None:
        """Whether c is below the pure-slip damping; None where the measurements do not say."""
        if self.averaged is None:
            return self.c < self.value
        possible = self._possible
        if possible is None or self._speeds < _FEWEST_SPEEDS:
            return None
        if possible[0] > USUAL_PROBABILITY:
            return True
        return False if possible[1] < 1 - USUAL_PROBABILITY else None

    @property
    def probability(self) -> float | None:
        """The probability that c is below; None without standard errors, or where too little was measured."""
        if self.averaged is None or (self._speeds >= _AVERAGED and not self.averaged.refused):
            return self.chance
        return self.chance if self.below is not None else None

    @property
    def range(self) -> Span | None:
        """From where to where the pure-slip damping is by the laws that may be meant; None without fits."""
        if self.averaged is None or self.averaged.dof <= 0:
            return None
        low, high = self.averaged.interval() if self._speeds >= _AVERAGED else self.averaged.range()
        return max(low, 0.0), max(high, 0.0)

    @property
    def if_friction_builds_up(self) -> float | None:
        """The pure-slip damping if friction builds up from 0 to the lowest measured speed, by the average of laws.

        None where that is nothing of it: without fits, or measured down to rest.
        """
        if self.averaged is None or self.averaged.unmeasured <= 0:
            return None
        return max(self.averaged.value - self.averaged.unmeasured, 0.0)

    @property
    def _of_unmeasured(self) -> str:
        """What is said of friction below the lowest measured speed, where it could turn the decision."""
        least = self.if_friction_builds_up
        if self.averaged is None or least is None or not least < self.c < self.value:
            return ""
        return (
            f"friction below {self.averaged.lowest:.3g} m/s was not measured: if it builds up from 0 there, the "
            f"threshold may be as low as {least:.3g} kg/s"
        )

    @property
    def probability_in_words(self) -> str | None:
        """The probability as every place shows it, like "> 0.999" or "= 0.87"."""
        if self.probability is None:
            return None
        return self._in_words(self.probability)

    @property
    def least(self) -> float:
        """The probability that is shown as no more than that."""
        return UNLIKELY if self.few else VERY_UNLIKELY

    def _in_words(self, chance: float) -> str:
        shown = chance_in_words(chance, self.least)
        return shown if shown[0] in "<>" else f"= {shown}"

    @property
    def range_in_words(self) -> str:
        """The range as text; empty if there is none."""
        if self.range is not None:
            return interval_text(*self.range)
        return ""

    @property
    def statement(self) -> str:
        """Where c is, how far from the threshold, and how sure that is."""
        return self._statement_of_few() if self.few else self._statement_of_value()

    def _statement_of_value(self) -> str:
        apart = ""
        remarks = list[str]()
        if self.value > 0:
            per_cent = 100 * abs(self.c / self.value - 1)
            apart = f"{per_cent:.0f} % " if per_cent >= 10 else f"{per_cent:.2g} % "
        else:
            remarks.append("no damping is needed")
        spread = math.hypot(self.standard_error, self.c_error)
        if spread > 0:
            remarks.append(f"{abs(self.c - self.value) / spread:.2g} standard errors")
        if self.probability_in_words is not None:
            remarks.append(f"P {self.probability_in_words} that c is below it")
        side = "below" if self.c < self.value else "above"
        threshold = f"the threshold of {value_text(self.value, self.standard_error)} kg/s"
        if self.averaged is not None and len(self.averaged.rows) > 1:
            threshold += f", averaged over {len(self.averaged.rows)} laws"
        more = ""
        if remarks:
            more = f" ({', '.join(remarks)})"
        unmeasured = f"; {self._of_unmeasured}" if self._of_unmeasured else ""
        return f"c = {value_text(self.c, self.c_error)} kg/s is {apart}{side} {threshold}{more}{unmeasured}"

    def _statement_of_few(self) -> str:
        c = f"c = {value_text(self.c, self.c_error)} kg/s"
        said = f"too few rows to rank laws: {self._speeds} speeds"
        advice = f"; measure at {RANKED} speeds or more"
        if self.averaged is None or self.range is None or self.by_law is None or self.chance is None:
            return f"{said}, and no law has fewer parameters{advice}"
        count = len(self.averaged.rows)
        laws = f"the {count} laws that may be meant" if count > 1 else "the one law that may be meant"
        where = f", friction below {self.averaged.lowest:.3g} m/s not measured,"
        where *= self.if_friction_builds_up is not None
        said += f"; the threshold is from {self.range_in_words} kg/s{where} by {laws}"
        if self._speeds < _FEWEST_SPEEDS:
            return f"{said}, and no decision is stated for {c}{advice}"
        if self._speeds >= _AVERAGED:
            chances = f"P {self._in_words(self.chance)}"
            agree = ""
        else:
            least, most = map(self._in_words, self.by_law)
            chances = f"P {least}" if least == most else f"P {least} to P {most}"
            agree = ", which agree" if self.below is not None else ", which do not agree"
        said += agree * (count > 1)
        advice = (f"; {self._of_unmeasured}" if self._of_unmeasured else "") + advice
        if self.below is None:
            return f"{said}: {chances} that {c} is below it{advice}"
        side = "below" if self.below else "above"
        unmeasured = f"; {self._of_unmeasured}" if self._of_unmeasured else ""
        return f"{c} is {side} the threshold; {said}: {chances} that c is below it{unmeasured}"


def unmeasured_part(law: FrictionLaw, lowest: float, V: float, N: float) -> float:
    """Return by how much the threshold is less if friction builds up from 0 to the lowest measured speed.

    In kg/s, by the least-squares slope average, equation (16) integrated by parts: friction that rises along a
    line, mu(v) v/lowest, in place of mu(v).
    """
    top = min(lowest, V)
    if top <= 0:
        return 0.0
    v = top / 2 * (1 + _NODES)
    missing = law.at_speeds(v) * (1 - v / lowest) * (1 - v / V) ** 3
    return max(float(5 * N / (2 * V**2) * (top / 2 * _SHARES @ missing)), 0.0)


def chance_in_words(chance: float, least: float) -> str:
    """Return a probability to two digits, or that it is below the least, or above one less it."""
    if chance < least:
        return f"< {least:g}"
    if chance > 1 - least:
        return f"> {1 - least:g}"
    return f"{chance:.2g}"


def value_text(value: float, error: float | None) -> str:
    """Return a value with its standard error as text, or to four digits if it has none."""
    if error:
        return text_with_error(value, error)
    return f"{value:.4g}"
