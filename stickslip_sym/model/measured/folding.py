"""Both signs of speed and force made one: a slip speed, and the coefficient of friction against it."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.core.aliases import BoolArray, IntArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.table import Table

__all__ = ["Column", "Folded", "fold"]

Column: TypeAlias = list[Fraction] | NDArray[np.float64]
"""Numbers as the file has them, or in double precision."""

FEW = 0.05  # share of rows with the other sign, up to which they are taken for noise of a small force


@dataclass(frozen=True)
class Folded:
    """Columns of one length: slip speeds in m/s, coefficients, their standard deviations, and what was done."""

    v: Column
    mu: Column
    sigma: Column | None
    notes: list[str]


def fold(values: Mapping[str, Column], table: Table, name: str) -> Folded:
    """Return slip speeds and coefficients from columns in SI units with any signs.

    Friction is against the motion, so with the speed its sign turns. Where speeds have both signs, or friction
    has in so few rows that it is noise, each value keeps its sign against the motion: magnitudes would push the
    mean of small forces up. Where friction has both signs and speeds have not, rows are of both directions of a
    stroke, and magnitudes are taken.

    Raises
    ------
    InputError
        If the signs of speed and friction do not go together, or a normal force or a standard deviation is not
        above 0.
    """
    what = "F_t" if "F_t" in values else "mu"
    speed, friction = values["v"], values[what]
    v_sign, sign = (np.sign(np.array(column, dtype=np.float64)).astype(int) for column in (speed, friction))
    reverses = bool((v_sign < 0).any() and (v_sign > 0).any())
    notes = ["both signs of speed folded"] if reverses else []
    against = v_sign * sign if reverses else sign
    below, above = int((against < 0).sum()), int((against > 0).sum())
    direction = -1 if below > above else 1
    if not (sign < 0).any():
        turns = np.ones_like(sign)
    elif min(below, above) <= FEW * (below + above):
        at_rest = np.where(sign < 0, -1, 1)  # a speed of 0 has no direction
        turns = np.where(v_sign == 0, at_rest, direction * v_sign) if reverses else np.full_like(sign, direction)
    elif reverses:
        wrong = int(np.argmax(against == -direction))
        raise InputError(
            f"{name}, line {table.lines[wrong]}, column {table.columns.places[what] + 1}: {what} = "
            f"{table.cells[what][wrong]} at v = {table.cells['v'][wrong]} is along the motion, and in most rows "
            "it is against it; give friction the sign of the speed, or no sign"
        )
    else:
        turns = np.where(sign < 0, -1, 1)
        notes.append(f"both signs of {what} folded")
    mu = _times(friction, turns)
    sigma = values.get("sigma_mu", values.get("sigma_F_t"))
    if sigma is not None:
        key = "sigma_mu" if "sigma_mu" in values else "sigma_F_t"
        _require(np.array(sigma, dtype=np.float64) > 0, table, key, name, "a standard deviation is above 0")
    if what == "F_t":
        normal = np.array(values["F_n"], dtype=np.float64)
        down = 1 if 2 * int((normal > 0).sum()) >= len(normal) else -1
        _require(down * normal > 0, table, "F_n", name, "a normal force is not 0, and has one sign")
        load = _times(values["F_n"], np.full(len(normal), down))
        mu = _over(mu, load)
        sigma = _over(sigma, load) if sigma is not None and "sigma_F_t" in values else sigma
    return Folded(_times(speed, np.where(v_sign < 0, -1, 1)), mu, sigma, notes)


def _require(good: BoolArray, table: Table, key: str, name: str, rule: str) -> None:
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(
            f"{name}, line {table.lines[row]}, column {table.columns.places[key] + 1}: {key} = "
            f"{table.cells[key][row]}; {rule}; mend the row, or begin it with #"
        )


def _times(column: Column, signs: IntArray) -> Column:
    if isinstance(column, np.ndarray):
        return column * signs
    return [value * int(sign) for value, sign in zip(column, signs, strict=True)]


def _over(column: Column, load: Any) -> Column:
    if isinstance(column, np.ndarray):
        ratio: NDArray[np.float64] = column / load
        return ratio
    return [value / other for value, other in zip(column, load, strict=True)]
