"""Results as JSON can hold them, by one rule.

A result says the attributes that its class names in `reported`, and a dataclass without that says all of its
fields; a method among them is called. Numbers are in SI units, and null where there is none; formulas are text.
"""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any


def content(value: Any) -> Any:
    """Return a result as nested dictionaries and lists of text, numbers, bools and None."""
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, str | Exception):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key.value if isinstance(key, Enum) else key): content(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # an array, or a number of NumPy
        return content(value.tolist())
    if isinstance(value, list | tuple):
        return [content(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if getattr(value, "is_number", False):
        return content(float(value))
    if hasattr(value, "free_symbols"):
        from stickslip_sym.output import printing

        return printing.text(value)
    if hasattr(value, "std_dev"):
        return {"value": value.nominal_value, "standard_error": value.std_dev}
    names = getattr(value, "reported", None) or (is_dataclass(value) and [field.name for field in fields(value)])
    if not names:
        return str(value)
    named = {name: getattr(value, name) for name in names}
    return {name: content(item() if callable(item) else item) for name, item in named.items()}
