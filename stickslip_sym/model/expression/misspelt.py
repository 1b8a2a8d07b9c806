"""Names in a formula that are probably no parameters: constants, and the slip speed v misspelt.

A parameter that is described, by its unit or as a `Parameter`, is what its description says, and never suspect.
"""

import warnings
from collections.abc import Sequence
from difflib import get_close_matches

from stickslip_sym.core.errors import InputError, InputWarning

__all__ = ["check_constant", "check_speed"]

_CONSTANTS = {
    "e": "write exp(x) for a power of Euler's number, and exp(1) for the number",
    **dict.fromkeys(("exp1", "exp_1", "euler", "euler_e", "e_euler"), "write exp(1)"),
    **dict.fromkeys(("pi", "pii", "ppi", "pie", "py"), "write pi"),
    **dict.fromkeys(("inf", "infinity", "infty", "oo", "nan"), "a law has finite numbers only"),
}
"""Names of constants, in small letters, with what to do."""

_SPEEDS = (
    "speed", "velocity", "velo", "vel", "slip", "vrel", "vslip", "vsliding", "vslide", "vrelative", "relv",
    "slipspeed", "slipvelocity", "slidingspeed", "slidingvelocity", "relativespeed", "relativevelocity",
    "relspeed", "relvelocity", "xdot", "dxdt",
)  # fmt: skip
"""Words for the slip speed, in small letters and without underscores."""

_CLOSE = 0.75  # difflib's ratio, of similar words: a letter wrong, missing or added in a word of four or more
_LIKE_V = frozenset({"vr", "vv", "v"})  # besides v: perhaps a reference speed
_DEPTH = 5  # calls from a line that makes a law to the warning
_SHOWN = 5  # names in a message


def check_constant(name: str) -> None:
    """Refuse the name of a parameter that is meant as a number.

    Raises
    ------
    InputError
        With what to write instead.
    """
    if (advice := _CONSTANTS.get(name.rstrip("_").lower())) is None:
        if name.rstrip("_") != "I":
            return
        advice = "a law is real"
    raise InputError(f"{name!r} looks like a constant; {advice}. {_or_declare(name)}")


def check_speed(names: Sequence[str], *, has_v: bool, bare: bool) -> None:
    """Refuse parameters that are meant as the slip speed, or warn of them.

    Parameters
    ----------
    names : sequence of str
        The parameters of the formula that have no description.
    has_v : bool
        Whether v stands in the formula.
    bare : bool
        Whether the formula is one name and nothing else: a constant coefficient, and meant as such.

    Raises
    ------
    InputError
        For a word such as speed; without v in the formula, for every name that begins with v.

    Warns
    -----
    InputWarning
        For vr and v_r beside v, and for a formula of several parts without v.
    """
    for name in names:
        if _is_speed(name) or (not has_v and name[0] in "vV"):
            missing = "" if has_v else "the formula has no v, and "
            what = f"{missing}{name!r} looks like the slip speed, which is v"
            raise InputError(f"{what}; write v. {_or_declare(name)}")
    if has_v:
        for name in names:
            if name.replace("_", "").lower() in _LIKE_V:
                _warn(f"{name!r} is taken for a parameter; the slip speed is v. {_or_declare(name)}")
    elif names and not bare:
        shown = ", ".join(names[:_SHOWN])
        _warn(
            f"the formula has no v, so mu is the same at every slip speed; its parameters: {shown}. If one of "
            "them is the slip speed, write v; if mu is constant, add 0*v to say so"
        )


def _is_speed(name: str) -> bool:
    plain = name.replace("_", "").lower()
    if plain in _SPEEDS:
        return True
    # Not vel_0 nor speed1: a digit makes it one speed among others.
    long = [word for word in _SPEEDS if len(word) > 4]
    return plain.isalpha() and bool(get_close_matches(plain, long, n=1, cutoff=_CLOSE))


def _or_declare(name: str) -> str:
    return f"If it is a parameter, say its unit: units={{{name!r}: ...}}"


def _warn(message: str) -> None:
    warnings.warn(message, InputWarning, stacklevel=_DEPTH)
