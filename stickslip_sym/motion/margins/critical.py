"""`critical`: every value of one quantity or parameter at which a given damping is just the pure-slip damping."""

import math
from collections.abc import Mapping
from typing import Any

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import lookup, read_rtol, real
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.along import Along
from stickslip_sym.motion.margins.value import Critical
from stickslip_sym.motion.thresholds.methods import Method, find_method
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

__all__ = ["critical"]


def critical(
    law: FrictionLaw | str,
    of: str,
    osc: Oscillator | None = None,
    /,
    *,
    c: float | None = None,
    V: float | None = None,
    N: float | None = None,
    m: float | None = None,
    k: float | None = None,
    method: str | Criterion | Method = "auto",
    rtol: float = 1e-3,
    within: tuple[float, float] | None = None,
    time_limit: float | None = None,
) -> tuple[Critical, ...]:
    """Return every value of one quantity or parameter at which the pure-slip damping is c, ascending.

    Parameters
    ----------
    law : FrictionLaw
        With all other parameters bound.
    of : str
        "V", "N", "m", "k", "c", or a parameter of the law; if the parameter has a value, it is sought around that.
    osc : Oscillator, optional
        Holds c, V, N, m and k, but for that which is sought.
    c, V, N, m, k : float, optional
        The others, in SI units. Without m and k averages of slopes only.
    method : str, Criterion or Method
        As for `pure_slip_damping`: "auto" takes for each value the cheapest method that knows its own error to be
        within `rtol`; without m and k "harmonic". "proof" encloses each value between two of which it is proved
        that stick-slip is there at one and not at the other; that there are no more such values it does not prove.
    rtol : float
        Relative error that is good enough, 1e-12 to 1; the width of a proved enclosure.
    within : (float, float), optional
        Two values of one sign between which to look. If not given, a parameter is sought from 1/100 of its value
        to 100 times it, and V, N, m and k where N/(V sqrt(k m)) is 1e-3 to 100; V also where the harmonic average
        comes close to c. There are 8 points a decade: two
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
        If a method does not reach `rtol`, or a proof does not succeed.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import critical, laws
    >>> (force,) = critical(laws.exponential.typical(), "N", c=2.0, V=0.5, method="equilibrium")
    >>> f"{force.value:.6f} {force.unit}"
    '9.959309 N'
    """
    law = as_law(law)
    known: dict[str, Any] = dict.fromkeys(("V", "N", "m", "k", "c")) | dict(law.parameters)
    lookup("quantity or parameter", of, known)
    values = {"c": c, "V": V, "N": N, "m": m, "k": k}
    numbers = {name: real(name, value) for name, value in values.items() if value is not None}
    if of in numbers:
        raise InputError(f"{of} is what is sought; leave its value out")
    if osc is not None:
        if numbers:
            raise InputError(
                f"{', '.join(numbers)} was given beside an Oscillator, which holds it; give one of both"
            )
        numbers = {name: getattr(osc, name) for name in values if name != of}
    missing = [name for name in ("c", "V", "N") if name not in (of, *numbers)]
    if missing and of != "c":
        raise InputError(f"{' and '.join(missing)} must be given to find {of}: {missing[0]}=...")
    rtol = read_rtol(rtol, least=1e-12, most=1.0)
    with deadline.time_limit(time_limit):
        if of == "c":
            return (_damping(law, numbers, method, rtol),)
        search = Along(law, of, numbers, within)
        chosen = find_method(method)
        if chosen is not None:
            chosen.check(law, numbers.get("V", math.inf), search.has_oscillator)
        return search.found(chosen, rtol)


def _damping(
    law: FrictionLaw, values: Mapping[str, float], method: str | Criterion | Method, rtol: float
) -> Critical:
    found = pure_slip_damping(law, **values, method=method, rtol=rtol)
    return Critical(
        "c", found.value, "kg/s", found.method, found.relative_error, found.sensitivity, found.enclosure
    )
