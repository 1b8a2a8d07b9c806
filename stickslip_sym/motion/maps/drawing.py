"""Drawings of maps: regions told apart by colour and hatching, and thresholds as curves."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.regimes.classification import Motion
from stickslip_sym.output.drawing import require_matplotlib

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.path import Path

__all__ = ["Region", "draw_basins", "draw_map", "draw_sweep", "edges", "regions_of"]


@dataclass(frozen=True)
class Region:
    """A kind of cell: what it is called, how it is drawn, and its letter in text."""

    name: str
    color: str
    hatch: str
    letter: str


# Colours of Okabe and Ito, which colour-blind people tell apart, lightened.
_STICK, _BOTH, _REST = "#E69F00", "#F0E442", "#BFE0F5"
_SLIP, _SLIP_STICK, _SLIP_REST, _ALL = "#009E73", "#CC79A7", "#56B4E9", "#D55E00"
_REGIONS = {
    (True, False, False): Region("stick-slip", _STICK, "", "S"),
    (True, True, False): Region("stick-slip or rest, by the start", _BOTH, "////", "b"),
    (False, True, False): Region("rest", _REST, "", "."),
    (False, False, True): Region("pure-slip cycle", _SLIP, "....", "p"),
    (True, False, True): Region("stick-slip or pure-slip cycle, by the start", _SLIP_STICK, "xxxx", "x"),
    (False, True, True): Region("rest or pure-slip cycle, by the start", _SLIP_REST, "oo", "o"),
    (True, True, True): Region("stick-slip, pure-slip cycle or rest, by the start", _ALL, "++", "*"),
}
_UNBOUNDED = Region("grows without bound", "#000000", "", "^")
_UNDECIDED = Region("undecided", "#FFFFFF", "", "?")
_FAILED = Region("failed", "#999999", "||", "!")
_MOTIONS = {
    Motion.STICK_SLIP: Region("comes to stick-slip", _STICK, "", "S"),
    Motion.PURE_SLIP: Region("comes to a pure-slip cycle", _SLIP, "....", "p"),
    Motion.DAMPED_SLIP: Region("comes to rest", _REST, "", "."),
    Motion.UNBOUNDED: _UNBOUNDED,
    Motion.UNDECIDED: _UNDECIDED,
}
_CURVES = {
    "exact": ("exact threshold", "-", "black"),
    "equilibrium": ("threshold of the equilibrium", ":", "black"),
    "least_squares": ("least-squares criterion", "--", "#0072B2"),
}
_CHANGES = {"Hopf": ":", "graze": "-", "fold": "--"}
_LOGARITHMIC = 30.0  # ratio of an axis's ends from which equal ratios are drawn as equal steps


def regions_of(found: Any) -> tuple[IntArray, list[Region]]:
    """Return for each cell the place of its region in a list of those that occur."""
    kinds = [*_REGIONS.values(), _UNBOUNDED, _UNDECIDED, _FAILED]
    index = np.full(found.motion.shape, kinds.index(_UNDECIDED))
    for key, region in _REGIONS.items():
        same = (found.stick_slip == key[0]) & (found.rest == key[1]) & (found.pure_slip == key[2])
        index[same] = kinds.index(region)
    index[found.motion == Motion.UNBOUNDED] = kinds.index(_UNBOUNDED)
    index[found.motion == Motion.UNDECIDED] = kinds.index(_UNDECIDED)
    index[(found.reason == Reason.FAILED) | (found.reason == Reason.TIME)] = kinds.index(_FAILED)
    present, places = np.unique(index, return_inverse=True)
    return places.reshape(index.shape), [kinds[i] for i in present]


def draw_map(found: Any) -> "Figure":
    """Return the figure of a map of motions."""
    figure, axes = _figure()
    place, kinds = regions_of(found)
    handles = _paint(axes, found.x.values, found.y.values, place, kinds)
    handles += _draw_curves(axes, found)
    axes.set(xlabel=found.x.label, ylabel=found.y.label)
    _title(axes, found.law, found.fixed)
    return _with_legend(figure, handles)


def draw_basins(found: Any) -> "Figure":
    """Return the figure of the motions that starts lead to."""
    from matplotlib.lines import Line2D

    figure, axes = _figure()
    present = [motion for motion in _MOTIONS if (found.motion == motion).any()]
    place = np.zeros(found.motion.shape, dtype=int)
    for i, motion in enumerate(present):
        place[found.motion == motion] = i
    handles = _paint(axes, found.x0, found.v0, place, [_MOTIONS[motion] for motion in present])
    for curve in found.regime.separatrices:
        axes.plot(curve.x, curve.v, "k-", linewidth=1.6)
    if found.regime.separatrices:
        handles.append(Line2D([], [], color="black", linewidth=1.6, label="separatrix"))
    axes.axhline(found.oscillator.V, color="black", linestyle=":", linewidth=1.0)
    handles.append(Line2D([], [], color="black", linestyle=":", linewidth=1.0, label="belt speed"))
    axes.set(xlabel="initial displacement x (m)", ylabel="initial velocity x' (m/s)")
    _title(axes, found.law, asdict(found.oscillator))
    return _with_legend(figure, handles)


def draw_sweep(found: Any) -> "Figure":
    """Return the figure of the shares of a box of starts over a quantity, with the places of birth and death."""
    figure, axes = _figure()
    present = [motion for motion in _MOTIONS if motion in found.share]
    values, shares = found.axis.values, np.array([found.share[motion] for motion in present])
    for change in found.changes:  # at which shares may jump
        place = int(np.searchsorted(values, change.value))
        sides = shares[:, [max(place - 1, 0), min(place, values.size - 1)]]
        values = np.insert(values, place, [change.value] * 2)
        shares = np.insert(shares, [place, place], sides, axis=1)
    edges = np.vstack([np.zeros(shares.shape[1]), np.cumsum(shares, axis=0)])
    handles: list[Artist] = []
    for motion, low, high in zip(present, edges, edges[1:], strict=False):
        kind = _MOTIONS[motion]
        handles.append(
            axes.fill_between(
                values, low, high, label=kind.name, facecolor=kind.color, hatch=kind.hatch, edgecolor="0.25",
                linewidth=0.5,
            )
        )  # fmt: skip
    for change in found.changes:
        axes.axvline(change.value, color="black", linestyle=_CHANGES[change.kind], linewidth=1.4)
        axes.annotate(
            f"{change.kind} {change.value:.6g}", (change.value, 0.02), rotation=90, fontsize=8, va="bottom",
            ha="right", backgroundcolor=(1, 1, 1, 0.7),
        )  # fmt: skip
    axes.set(xlabel=found.axis.label, ylabel="share of the box of starts", ylim=(0, 1))
    axes.set_xlim(found.axis.values[0], found.axis.values[-1])
    return _with_legend(figure, handles)


def _title(axes: "Axes", law: FrictionLaw, values: dict[str, float]) -> None:
    scene = ", ".join(f"{name} = {value:g} {QUANTITIES[name].unit}" for name, value in values.items())
    axes.set_title(f"{law.name or 'friction law'}: {scene}", fontsize=10)


def _figure() -> "tuple[Figure, Axes]":
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 5.6), layout="constrained")
    return figure, figure.add_subplot()


def _paint(axes: "Axes", x: FloatArray, y: FloatArray, place: IntArray, kinds: list[Region]) -> "list[Artist]":
    """Fill cells with colours and hatching; return the handles of the legend."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch, PathPatch

    x_edges, y_edges = edges(x), edges(y)
    axes.pcolormesh(
        x_edges, y_edges, place, cmap=ListedColormap([kind.color for kind in kinds]),
        vmin=-0.5, vmax=len(kinds) - 0.5, rasterized=True,
    )  # fmt: skip
    for i, kind in enumerate(kinds):
        if kind.hatch:
            cells = _outline(x_edges, y_edges, place == i)
            axes.add_patch(PathPatch(cells, facecolor="none", edgecolor="black", hatch=kind.hatch, linewidth=0))
    for name, values in (("x", x), ("y", y)):
        if _is_logarithmic(values):
            axes.set(**{f"{name}scale": "log"})
    axes.set(xlim=(x_edges[0], x_edges[-1]), ylim=(y_edges[0], y_edges[-1]))
    return [
        Patch(facecolor=kind.color, hatch=kind.hatch, edgecolor="0.25", linewidth=0.5, label=kind.name)
        for kind in kinds
    ]


def _outline(x_edges: FloatArray, y_edges: FloatArray, chosen: BoolArray) -> "Path":
    """Return the path round cells: a rectangle for each run of neighbours in a row."""
    from matplotlib.path import Path

    steps = np.diff(np.pad(chosen.astype(int), ((0, 0), (1, 1))), axis=1)
    (rows, first), (_, behind) = np.nonzero(steps == 1), np.nonzero(steps == -1)
    left, right, low, high = x_edges[first], x_edges[behind], y_edges[rows], y_edges[rows + 1]
    corners = np.array([[left, low], [right, low], [right, high], [left, high], [left, low]])
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    return Path(corners.transpose(2, 0, 1).reshape(-1, 2), np.tile(codes, rows.size))


def _is_logarithmic(values: FloatArray) -> bool:
    """Whether the values are spread by equal ratios rather than equal steps."""
    if values.size < 3 or values[0] <= 0 or values[-1] / values[0] < _LOGARITHMIC:
        return False
    return bool(np.ptp(np.diff(np.log(values))) < 0.1 * np.diff(np.log(values)).mean())


def edges(values: FloatArray) -> FloatArray:
    """Return the places half way between the values, and as far beyond the first and the last."""
    if values.size == 1:
        return values + np.array([-0.5, 0.5]) * (abs(float(values[0])) or 1.0) * 0.1
    if _is_logarithmic(values):
        return np.exp(edges(np.log(values)))
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _draw_curves(axes: "Axes", found: Any) -> "list[Artist]":
    from matplotlib.lines import Line2D

    handles: list[Artist] = []
    for name, (label, style, color) in _CURVES.items():
        curve = found.thresholds[name]
        if not np.isfinite(curve).any():
            continue
        look: dict[str, Any] = {"linestyle": style, "color": color, "linewidth": 1.6}
        if found.y.name == "c":
            axes.plot(found.x.values, curve[0], **look)
        elif found.x.name == "c":
            axes.plot(curve[:, 0], found.y.values, **look)
        else:
            beyond = curve - found.fixed["c"]
            if min(curve.shape) == 1 or not np.nanmin(beyond) < 0 < np.nanmax(beyond):
                continue
            axes.contour(
                found.x.values, found.y.values, beyond, levels=[0], colors=color, linestyles=[style],
                linewidths=1.6,
            )  # fmt: skip
        handles.append(Line2D([], [], label=label, **look))
    return handles


def _with_legend(figure: "Figure", handles: "list[Artist]") -> "Figure":
    figure.legend(
        handles=handles, loc="outside lower center", ncols=2, fontsize=8, handlelength=3, handleheight=1.6
    )
    return figure
