"""What the paper claims, a row each, with the verdict that our computation must come to.

The verdict here is what a reader of the report finds; a check fails when its evidence gives another one.
"""

from dataclasses import dataclass
from enum import Enum

from paper_checks.printed import PRINTED


class Outcome(Enum):
    """How far a claim holds."""

    REPRODUCED = "reproduced"
    QUALIFIED = "reproduced with a qualification"
    NOT_REPRODUCED = "not reproduced"

    @classmethod
    def of(cls, reproduced: bool, qualified: bool) -> "Outcome":
        """Return the verdict of two conditions that a check computed."""
        return cls.REPRODUCED if reproduced else cls.QUALIFIED if qualified else cls.NOT_REPRODUCED


@dataclass(frozen=True)
class Claim:
    """One claim."""

    id: str
    where: str  # in the paper
    says: str  # in a few words
    paper: str  # the paper's value or equation
    outcome: Outcome = Outcome.REPRODUCED


QUALIFIED, NOT_REPRODUCED = Outcome.QUALIFIED, Outcome.NOT_REPRODUCED

CLAIMS = {
    claim.id: claim
    for claim in (
        Claim("E1", "(1)", "stick: x' = V, f = c x' + k x, kept while |f| <= mu_s N", "(1)"),
        Claim("E2", "(2)", "slip: the equation of motion, and the sign of the kinetic force", "(2)"),
        Claim("E3", "(3), Fig. 2a", "exponential law: starts at mu_s, falls, tends to mu_m", "mu_s to mu_m"),
        Claim("E4", "(4), Fig. 2b", "polynomial law: starts at mu_s, minimum mu_m at v_m", "mu_m at v_m"),
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
        Claim("N1", "sec. 3", "damping ratios of the five dampings", " ".join(PRINTED["N1"]["ratios"])),
        Claim("N2", "sec. 3", "exponential law: pure slip at c, kg/s", PRINTED["N2"]["c"]),
        Claim("N3", "sec. 3", "polynomial law: pure slip at c, kg/s", PRINTED["N3"]["c"], QUALIFIED),
        Claim(
            "N4", "sec. 5", "polynomial law: transition speed at c = 0, in v_m",
            f"sqrt({PRINTED['N4']['ratio']}) = {PRINTED['N4']['rounded']}",
        ),
        Claim(
            "F3", "Fig. 3", "exponential law: the motions at five dampings",
            f"three stick-slip, pure at {PRINTED['F3']['dampings'][3]}, damped", QUALIFIED,
        ),
        Claim(
            "F4", "Fig. 4", "polynomial law: the motions at five dampings",
            f"three stick-slip, pure at {PRINTED['F4']['dampings'][3]}, damped",
        ),
        Claim("F5", "Fig. 5", "P and Q coincide in stick-slip and pure slip only", "V_Q = V, V, < V"),
        Claim("F6", "Fig. 6", "(17) agrees with the numerical threshold, Galvanetto & Bishop do not", "(17)"),
        Claim(
            "F7", "Fig. 7", "(18) is closer than Galvanetto & Bishop and Thomsen & Fidlin", "(18)", QUALIFIED
        ),
        Claim("F8", "Fig. 8", "exponential law, c = 2: A at V = 0.5, B at V = 0.8", "stick-slip, damped slip"),
        Claim("F9", "Fig. 9", "polynomial law, c = 2: C at V = 0.5, D at V = 0.8", "stick-slip, damped slip"),
        Claim("F10", "Fig. 10", "the stick-slip region shrinks for mu_m = 0.2, 0.3, 0.4", "shrinks"),
        Claim("S1", "after (16)", "m and k do not affect the damping of (16)", "none"),
        Claim("S2", "sec. 5", "the natural frequency has no direct relevance", "none", QUALIFIED),
        Claim("S3", "sec. 4", "pure slip: velocity from -V to V, close to harmonic", "-V", QUALIFIED),
        Claim("S4", "sec. 5", "the pure-slip damping falls with the belt speed", "falls"),
        Claim(
            "S5", "sec. 5", "exponential law: no transition speed, and no escape from stick-slip, as c -> 0",
            "infinite", QUALIFIED,
        ),
        Claim(
            "S6", "sec. 5", "polynomial law: no stick-slip above this speed, whatever c",
            f"{PRINTED['S6']['speed']} v_m", QUALIFIED,
        ),
        Claim(
            "S7", "sec. 3", "one damping separates, and pure slip is at that value only", "one value", QUALIFIED
        ),
        Claim("S8", "Fig. 3d", "at the threshold the slip amplitude stays constant", "constant", QUALIFIED),
        Claim("S9", "sec. 5", "a larger mu_s - mu_m makes stick-slip easier", "easier"),
        Claim("S10", "sec. 1", "criteria from the equilibrium err at considerable amplitudes", "some errors"),
        Claim(
            "S11", "sec. 4", "a nonlinear coefficient gives no closed form", "no closed form", NOT_REPRODUCED
        ),
    )
}  # fmt: skip
