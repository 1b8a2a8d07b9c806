"""`critical`: every value of one quantity or parameter at which a given damping is just the pure-slip damping."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import lookup, read_rtol, real
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.margins.along import Along
from stickslip_sym.motion.margins.value import Critical
from stickslip_sym.motion.thresholds.rungs import Rung, find
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

__all__ = ["critical"]


def critical(
    of: str,
    law: FrictionLaw,
    *,
    c: float | None = None,
    V: float | None = None,
    N: float | None = None,
    m: float | None = None,
    k: float | None = None,
    method: str | Criterion | Rung = "auto",
    rtol: float = 1e-3,
    within: tuple[float, float] | None = None,
    time_limit: float | None = None,
) -> tuple[Critical, ...]:
    """Return every value of one quantity or parameter at which the pure-slip damping is c, ascending.

    Parameters
    ----------
    of : str
        "V", "N", "m", "k", "c", or a parameter of the law; if the parameter has a value, it is sought around that.
    law : FrictionLaw
        With all other parameters bound.
    c, V, N, m, k : float, optional
        The others, in SI units. Without m and k averages of slopes only.
    method : str, Criterion or Rung
        As for `pure_slip_damping`. "auto" takes the orbit where the law is smooth, and simulation where it is not
        or the orbit has no value; without m and k "harmonic". For "V" see `transition_speed`. "proof" encloses
        each value between two of which it is proved that stick-slip is there at one and not at the other; that
        there are no more such values it does not prove.
    rtol : float
        Relative error that is good enough, 1e-12 to 1; the width of a proved enclosure.
    within : (float, float), optional
        Two values of one sign between which to look. If not given, a parameter is sought from 1/100 of its value
        to 100 times it, and N, m and k where N/(V sqrt(k m)) is 1e-3 to 100. There are 8 points a decade: two
        values closer together are found if the grid shows the extremum between them, and may otherwise be missed.
        An average that is linear or a polynomial needs no range: all values are found, by their polynomial.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    tuple of Critical
        Empty where there is none.

    Raises
    ------
    InputError
        For an unknown name or method, numbers that are missing or unusable, or an average that does not depend on
        m and k.
    NotConverged
        If a rung does not reach `rtol`, or a proof does not succeed.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> (force,) = critical("N", laws.exponential.typical(), c=2.0, V=0.5, method="equilibrium")
    >>> f"{force.value:.6f} {force.unit}"
    '9.959309 N'
    """
    known: dict[str, Any] = dict.fromkeys(("V", "N", "m", "k", "c")) | dict(law.parameters)
    lookup("quantity or parameter", of, known)
    given = {"c": c, "V": V, "N": N, "m": m, "k": k}
    if given.get(of) is not None:
        raise InputError(f"{of} is what is sought; leave its value out")
    needed = [name for name in ("c", "V", "N") if name != of and given[name] is None]
    if needed:
        raise InputError(f"{' and '.join(needed)} must be given to find {of}: {needed[0]}=...")
    rtol = read_rtol(rtol, least=1e-12, most=1.0)
    numbers = {name: real(name, value) for name, value in given.items() if value is not None}
    with deadline.time_limit(time_limit):
        if of == "c":
            return (_damping(law, numbers, method, rtol),)
        rung = find(method)
        search = Along(of, law, numbers, within)
        if rung is not None:
            rung.require_oscillator(np.ones(1) if search.has_oscillator else None)
        return search.found(rung, rtol)


def _damping(
    law: FrictionLaw, given: Mapping[str, float], method: str | Criterion | Rung, rtol: float
) -> Critical:
    found = pure_slip_damping(law, **given, method=method, rtol=rtol)
    return Critical("c", found.value, "kg/s", found.method, found.error, found.sensitivity, found.enclosure)
