"""A friction law as plain content that JSON holds, exact, and back: for files."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np
from uncertainties import UFloat, correlated_values_norm, correlation_matrix

from stickslip_sym.core.aliases import Json
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import exact, require_type
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.samples import SampledCurve
from stickslip_sym.output.printing import text

_ABOUT = ("name", "source", "validity")


def law_out(law: FrictionLaw) -> dict[str, object]:
    """Return a law as nested dictionaries and lists of text: its formula as it was read, and will be again."""
    content: dict[str, object] = {key: getattr(law, key) for key in _ABOUT} | {
        "parameters": [asdict(parameter) for parameter in law.parameters.values()],
        "values": {name: str(value) for name, value in law.values.items()},
        "static": law.static_formula,
    }
    if law.uncertain:
        content["errors"] = _errors_out(law.uncertain)
    if law.curve is None:
        return content | {"formula": law.formula or text(law.expr)}
    cubics = [[str(coefficient) for coefficient in cubic] for cubic in law.curve.cubics]
    end = None if law.curve.end is None else str(law.curve.end)
    return content | {"places": [str(place) for place in law.curve.places], "cubics": cubics, "end": end}


def law_in(content: Json) -> FrictionLaw:
    """Return the law that `law_out` wrote; other content is refused by one error of Python or another."""
    about = {key: content[key] for key in _ABOUT}
    static = content["static"]
    require_type("static", static, str | None, "text")
    parameters = [Parameter(**described) for described in content["parameters"]]
    if "places" in content:
        curve = SampledCurve(
            tuple(exact(place, "a place") for place in content["places"]),
            tuple(tuple(exact(number, "a coefficient") for number in cubic) for cubic in content["cubics"]),
            None if content["end"] is None else exact(content["end"], "the end"),
        )
        law = FrictionLaw.from_curve(curve, **about)
        if static is not None:
            law = law.with_static(static, parameters=parameters)
    else:
        require_type("formula", content["formula"], str, "text")
        law = FrictionLaw(content["formula"], static=static, parameters=parameters, **about)
    law = law.bind(**content["values"])
    if "errors" in content:
        law = law.with_errors(_errors_in(content["errors"], law))
    return law


def _errors_out(uncertain: Mapping[str, UFloat]) -> dict[str, object]:
    return {
        "standard": {name: value.std_dev for name, value in uncertain.items()},
        "correlation": correlation_matrix(list(uncertain.values())).tolist(),
    }


def _errors_in(content: Json, law: FrictionLaw) -> dict[str, UFloat]:
    """Return the values of a law that carry a standard error, correlated as they were."""
    pairs = {name: (float(law.values[name]), float(error)) for name, error in content["standard"].items()}
    correlation = np.array(content["correlation"], dtype=np.float64)
    if not all(0 < error < math.inf for _, error in pairs.values()) or correlation.shape != (len(pairs),) * 2:
        raise InputError("a standard error is positive and finite, and each has its row of correlations")
    return dict(zip(pairs, correlated_values_norm(list(pairs.values()), correlation), strict=True))


def text_of_law(law: FrictionLaw) -> str:
    """Return a law as one text."""
    return json.dumps(law_out(law), sort_keys=True)
