"""Why a criterion and the oscillator's threshold differ in a scene, and what scattered points deserve."""

import math
from collections.abc import Mapping

from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.formula.evaluation.averages import slope_average
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

__all__ = ["LARGE", "reasons", "spread"]

LARGE = 0.05  # relative difference of a criterion from the threshold from which on its reason is looked for
_STIFFER = 1e4  # times the stiffness: N/(V sqrt(k m)) falls to a hundredth
_RTOL = 1e-6


def reasons(
    law: FrictionLaw, criterion: Criterion, scene: Mapping[str, float], value: float, threshold: float
) -> list[str]:
    """Return what a criterion and the event-driven threshold differ by, part by part, each computed.

    - `law`: with all parameters bound.
    - `scene`: V, N, m and k in SI units.
    - `value, threshold`: the criterion and the threshold, in kg/s.
    """
    found = []
    eta = scene["N"] / (scene["V"] * math.sqrt(scene["k"] * scene["m"]))
    weak = float(slope_average(law, harmonic)(V=scene["V"], N=scene["N"]))
    if criterion != harmonic and abs(weak - value) > LARGE * abs(value):
        found.append(
            f"the weight: for weak friction the threshold is the harmonic average, {weak:.4g} kg/s, and the "
            f"criterion {criterion.name} weighs other slip speeds"
        )
    if law.static is not None:
        plain = FrictionLaw(law.expr).bind(
            **{n: v for n, v in law.values.items() if law.expr.has(law.parameters[n].symbol)}
        )
        without = _threshold(plain, scene)
        if without is not None and abs(without - threshold) > LARGE * abs(threshold):
            found.append(
                f"the static coefficient, which no slope average sees: without it the threshold is "
                f"{without:.4g} kg/s"
            )
    stiff = _threshold(law, {**scene, "k": scene["k"] * _STIFFER})
    if (
        stiff is not None
        and abs(stiff - weak) < abs(threshold - weak) / 3
        and abs(threshold - stiff) > LARGE * abs(threshold)
    ):
        found.append(
            f"friction that is not weak: N/(V sqrt(k m)) = {eta:.3g}; at a hundredth of that (k times 10^4) "
            f"the threshold is {stiff:.4g} kg/s"
        )
    return found


def _threshold(law: FrictionLaw, scene: Mapping[str, float]) -> float | None:
    try:
        return float(pure_slip_damping(law, **scene, method="simulation", rtol=_RTOL).value)
    except StickSlipError:
        return None


def spread(law: FrictionLaw, criterion: Criterion, V: float, N: float) -> float:
    """Return the standard error of a criterion of measured points, in kg/s: the jackknife over the points.

    Each point but the first and the last is left out in turn; 0 for fewer than five points.
    """
    assert law.curve is not None
    v = [float(place) for place in law.curve.places]
    mu = [float(cubic[0]) for cubic in law.curve.cubics]
    if law.curve.end is not None:
        v, mu = [*v, float(law.curve.end)], [*mu, float(law.mu(float(law.curve.end)))]
    if len(v) < 5:
        return 0.0
    values = []
    for left_out in range(1, len(v) - 1):
        kept = [i for i in range(len(v)) if i != left_out]
        other = FrictionLaw.from_samples(
            [v[i] for i in kept], [mu[i] for i in kept], extrapolate=law.curve.end is None
        )
        values.append(float(slope_average(other, criterion)(V=V, N=N)))
    mean = sum(values) / len(values)
    return math.sqrt((len(values) - 1) / len(values) * sum((value - mean) ** 2 for value in values))
