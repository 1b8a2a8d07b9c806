"""What the paper claims, a row each, with the verdict that our computation must come to.

The verdict here is what a reader of the report finds; a check fails when its evidence gives another one.
"""

from dataclasses import dataclass
from enum import Enum

__all__ = ["CLAIMS", "Claim", "Outcome"]


class Outcome(Enum):
    """How far a claim holds."""

    REPRODUCED = "reproduced"
    QUALIFIED = "reproduced with a qualification"
    NOT_REPRODUCED = "not reproduced"


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes
    ----------
    id : str
    where : str
        The place in the paper.
    says : str
        The claim in a few words.
    paper : str
        The paper's value or equation.
    outcome : Outcome
    """

    id: str
    where: str
    says: str
    paper: str
    outcome: Outcome = Outcome.REPRODUCED


CLAIMS = {
    claim.id: claim
    for claim in (
        Claim("E1", "(1)", "stick: x' = V, f = c x' + k x, kept while |f| <= mu_s N", "(1)"),
        Claim("E2", "(2)", "slip: the equation of motion, and the sign of the kinetic force", "(2)"),
        Claim("E3", "(3)", "exponential law: starts at mu_s, falls, tends to mu_m", "mu_s to mu_m"),
        Claim("E4", "(4)", "polynomial law: starts at mu_s, minimum mu_m at v_m", "mu_m at v_m"),
        Claim("E5", "(5), (6)", "work and energy from P to Q; the spring's work vanishes", "(5), (6)"),
        Claim("E7", "(7)", "the integral is negative for damped slip", "< 0"),
        Claim("E9", "(8), (9)", "the linearised force for v_r <= 0", "(9)"),
        Claim("E10", "(10)", "(9) put into (6) and rearranged", "(10)"),
        Claim("E11", "(11)", "(10) is true for pure slip if and only if c = a N", "c = a N"),
        Claim("E13", "(13)", "change of variable in (12), limits and weight included", "(13)"),
        Claim("E15", "(15)", "a and b from (14), and that they are a minimum", "(15)"),
        Claim("E16", "(16)", "(15) put into (11)", "(16)"),
        Claim("E17", "(17)", "the exponential law put into (16)", "(17)"),
        Claim("E18", "(18)", "the polynomial law put into (16)", "(18)"),
        Claim("N1", "sec. 3", "damping ratios of the five dampings", "0 0.05 0.1 0.1287 0.175"),
        Claim("N2", "sec. 3", "exponential law: pure slip at c, kg/s", "2.574"),
        Claim("N3", "sec. 3", "polynomial law: pure slip at c, kg/s", "3.038", Outcome.QUALIFIED),
        Claim("N4", "sec. 5", "polynomial law: transition speed at c = 0, in v_m", "sqrt(21/26) = 0.9"),
    )
}
