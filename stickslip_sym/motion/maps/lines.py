"""The cells along lines of a map: plain content in, plain content out, so that other processes may decide them."""

from functools import lru_cache
from itertools import accumulate

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.content import law_of_text
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.axes import SCENE
from stickslip_sym.motion.maps.cells import CURVES, REASONS, Cells, Reason
from stickslip_sym.motion.maps.checkpoint import UNFINISHED, Plain
from stickslip_sym.motion.maps.columns import by_collocation
from stickslip_sym.motion.maps.together import Asked, alone, decide_together

__all__ = ["decide_lines", "lines_together", "tasks_of"]

_CELLS = 300  # that are decided at once, where that costs less than one by one


def tasks_of(law: str, lines: list[dict[str, float]], along: str, values: list[float], rtol: float) -> list[Plain]:
    """Return the tasks that a map consists of, a line each, for `decide_lines`.

    - `law`: as text.
    - `lines`: for each line the values of quantities and parameters.
    - `along, values`: another quantity or parameter, and its values.
    """
    request = {"law": law, "along": along, "values": values, "rtol": rtol}
    return [request | {"line": line} for line in lines]


def lines_together(values: int) -> int:
    """Return how many lines of so many values `decide_lines` is given at once."""
    return max(1, _CELLS // values)


def _scene(text: str, values: dict[str, float]) -> tuple[FrictionLaw, Oscillator]:
    own = tuple((name, value) for name, value in values.items() if name not in SCENE)
    return _law(text, own), Oscillator(**{name: values[name] for name in "VNmk"})


@lru_cache(maxsize=_CELLS)  # scenes of one law share it, so that what is computed of it is computed once
def _law(text: str, values: tuple[tuple[str, float], ...]) -> FrictionLaw:
    return law_of_text(text).bind(**dict(values))


def decide_lines(tasks: list[Plain]) -> list[Plain]:
    """Decide the cells along some lines of a map: plain content in, plain content out.

    - `tasks`: "law": a law as text; "line": the values of quantities and parameters; "along": the name of another
      one, and its "values"; "rtol". They differ in the line.

    Returns for each line lists by the names in `Cells`; thresholds have one entry if the lines are along c, else
      one a cell.
    """
    along, values = tasks[0]["along"], tasks[0]["values"]
    places, scenes = list[int](), list[tuple[dict[str, float], list[float]]]()
    for i, task in enumerate(tasks):
        fixed = task["line"]
        whole = [(fixed, values)]
        parts = whole if along == "c" else [(fixed | {along: value}, [fixed["c"]]) for value in values]
        scenes += parts
        places += [i] * len(parts)
    found = _decided(tasks[0], scenes, singly=along == "c" and _by_collocation(tasks[len(tasks) // 2]))
    return [
        _line([cells for line, cells in zip(places, found, strict=True) if line == i]) for i in range(len(tasks))
    ]


def _by_collocation(task: Plain) -> bool:
    """Tell whether collocation decides the dampings of a line, and so is likely to do of its neighbours."""
    try:
        return by_collocation(*_scene(task["law"], task["line"]))
    except StickSlipError:
        return False


def _line(parts: list[Cells]) -> Plain:
    line: Plain = {
        name: [entry for cells in parts for entry in getattr(cells, name)]
        for name in ("motion", "attractors", "reason")
    }
    for name in CURVES:
        line[name] = [getattr(cells, name) for cells in parts]
    starts = accumulate((len(cells.motion) for cells in parts[:-1]), initial=0)
    line["notes"] = [
        [start + i, text] for start, cells in zip(starts, parts, strict=True) for i, text in cells.notes.items()
    ]
    line[UNFINISHED] = REASONS.index(Reason.TIME) in line["reason"]
    return line


def _decided(task: Plain, scenes: list[tuple[dict[str, float], list[float]]], *, singly: bool) -> list[Cells]:
    """Decide the cells of some scenes.

    - `singly`: try collocation, scene by scene.
    """
    found: dict[int, Cells] = {}
    asked: dict[int, Asked] = {}
    for i, (values, c) in enumerate(scenes):
        try:
            deadline.check_time()
            asked[i] = Asked(*_scene(task["law"], values), np.array(c))
        except StickSlipError as error:
            found[i] = Cells.failed(len(c), error)
    for i in [i for i, one in asked.items() if singly and by_collocation(one.law, one.osc)]:
        found[i] = alone(asked.pop(i), rtol=task["rtol"])
    found |= dict(zip(asked, decide_together(list(asked.values()), rtol=task["rtol"]), strict=True))
    return [found[i] for i in range(len(scenes))]
