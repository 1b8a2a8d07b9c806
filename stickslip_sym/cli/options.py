"""The options of the commands, each declared once.

A command is a function of `Given`, which notes what is read of it: `Given.all_used` refuses an option that does
nothing here, so that none is dropped without a word.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from stickslip_sym.cli.numbers import read_number
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.operating_point import PAPER

__all__ = [
    "CRITERIA", "CRITERION", "DAMPING", "DESCRIPTION", "FILE_OF_MEASUREMENTS", "JSON", "LAW", "LAW_NAMES",
    "METHOD", "NUMBER", "POINT", "RANGE", "Given", "command", "file_option", "option", "time_limit",
]  # fmt: skip

_BELONGS = {
    "name": "it belongs to a formula or to measured points",
    "source": "it belongs to a formula or to measured points",
    "unit": "it belongs to the parameters of a formula or of --static",
    "extrapolate": "it belongs to --from-csv: a formula holds at all speeds",
    **dict.fromkeys(
        ("column", "radius", "speeds", "leave_out", "keep_outliers"), "it belongs to a file of measurements"
    ),
    "x0": "it belongs to --basins or --all", "v0": "it belongs to --basins or --all",
    "c": "the damping has no part in this",
    **dict.fromkeys(("fragment", "steps", "symbol"), "it belongs to --latex FILE"),
}  # fmt: skip
_PICTURES = (".svg", ".png", ".pdf")


class Given:
    """The options of a command, and which of them were read.

    Attributes
    ----------
    command : str
        Name of the command.
    """

    def __init__(self, context: click.Context) -> None:
        self._context, self._read = context, {"overwrite", "json"}
        self.command = str(context.command.name)

    def __getitem__(self, name: str) -> Any:
        """Return the value of an option, which is used hereby; None where the command has no such option."""
        self._read.add(name)
        return self._context.params.get(name)

    def has(self, name: str) -> bool:
        """Return whether an option stands on the command line."""
        return self._context.get_parameter_source(name) is ParameterSource.COMMANDLINE

    def all_used(self) -> None:
        """Refuse options that were given and have not been read; commands ask before they begin to compute.

        Raises `InputError` for the first of them.
        """
        for parameter in self._context.command.params:
            if parameter.name not in self._read and self.has(str(parameter.name)):
                option = max(parameter.opts, key=len)
                reason = _BELONGS.get(str(parameter.name), "it has no part in what was asked for")
                raise InputError(f"{option} does nothing here: {reason}; leave it out")


def command(name: str, *parameters: click.Parameter | Sequence[click.Parameter]) -> Callable[..., click.Command]:
    """Return a decorator that makes a command of a function of `Given`; its docstring is the help."""
    flat: list[click.Parameter] = []
    for one in parameters:
        flat += [one] if isinstance(one, click.Parameter) else one
    if any(isinstance(one.type, _File) for one in flat):
        flat.append(_OVERWRITE)

    def made(function: Callable[[Given], None]) -> click.Command:
        return _Command(
            name,
            params=flat,
            help=function.__doc__,
            callback=lambda **_: function(Given(click.get_current_context())),
        )

    return made


class _Command(click.Command):
    """A command that takes an option once. Otherwise the last value would win without a word."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse options that are given twice, but for flags and those that may be repeated."""
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for option in order:
            single = not (getattr(option, "is_flag", True) or option.multiple)
            if single and order.count(option) > 1:
                raise InputError(f"{option.opts[0]} is given twice; give it once")
        return super().parse_args(ctx, args)


class _Number(click.ParamType[float]):
    """A number of a possible size, as people write one: 0.5, 1e-3 or 1/3."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        return (
            value if isinstance(value, float) else read_number(value, str(param.name) if param else "the number")
        )


class _Range(click.ParamType[tuple[float | None, float | None]]):
    """LOW:HIGH; where `half` is true either may be left out."""

    name = "range"

    def __init__(self, *, half: bool = False) -> None:
        self.half = half

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float | None, float | None]:
        """Return both ends."""
        if isinstance(value, tuple):
            return value
        option = param.opts[0] if param else "the range"
        low, colon, high = value.partition(":")
        if not colon or (not self.half and not (low and high)):
            raise InputError(f"{option} {value[:60]!r} is not LOW:HIGH; write for example {option} 0.1:10")
        first, last = (read_number(end, option) if end else None for end in (low, high))
        return first, last


NUMBER = _Number()
"""The type of an option that takes a number."""
RANGE = _Range()
"""The type of an option that takes LOW:HIGH."""


class _File(click.ParamType[Path]):
    """The name of a file to write, refused before the work where it cannot be written."""

    name = "file"

    def __init__(self, endings: Sequence[str], *, draws: bool) -> None:
        self.endings, self.draws = endings, draws

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path."""
        from stickslip_sym.output.files import is_kept

        path, option = Path(value), max(param.opts, key=len) if param else "the option"
        if not path.parent.is_dir():
            raise InputError(f"cannot write {str(path)!r}: there is no folder {str(path.parent)!r}; make it first")
        if self.endings and path.suffix.lower() not in self.endings:
            raise InputError(f"{option} {path}: its ending is none of {', '.join(self.endings)}")
        if self.draws:
            from stickslip_sym.output.drawing import require_matplotlib

            require_matplotlib()
        if ctx is not None and not ctx.params.get("overwrite") and is_kept(path):
            raise InputError(
                f"{str(path)!r} exists, and {option} writes: name another file, or add --overwrite to replace it"
            )
        return path


def file_option(
    name: str, text: str, *, draws: bool = False, endings: Sequence[str] = (), default: str | None = None
) -> click.Option:
    """Return an option that takes the name of a file to write, that of a picture if it draws."""
    kind = _File(_PICTURES if draws else endings, draws=draws)
    names = [name, "-o"] if name == "--output" else [name]
    return click.Option(names, type=kind, metavar="FILE", help=text, default=default)


def _complete(names: Callable[[], Sequence[str]]) -> Callable[..., list[str]]:
    return lambda context, parameter, begun: [name for name in names() if name.startswith(begun)]


def _laws() -> list[str]:
    from stickslip_sym import laws

    return list(laws.catalogue)


def _criteria() -> list[str]:
    from stickslip_sym import criteria

    return list(criteria.catalogue)


def _methods() -> list[str]:
    from stickslip_sym.motion.thresholds.methods import methods

    return [*methods(), "auto"]


def option(*names: str, **more: Any) -> click.Option:
    """Return an option; ``multiple`` ones say in their help that they may be repeated."""
    if more.get("multiple"):
        more["help"] += " May be repeated."
    return click.Option(list(names), **more)


_OVERWRITE = click.Option(["--overwrite"], is_flag=True, is_eager=True, help="Let files be replaced.")
JSON = click.Option(["--json"], is_flag=True, help="Print JSON instead of text.")
DESCRIPTION = [
    option("--static", metavar="MU", help="Static coefficient above mu(0+): a number or a formula."),
    option("--name", metavar="NAME", help="Name of a formula or of points."),
    option("--unit", metavar="NAME=UNIT", multiple=True, help="Unit of a formula's parameter."),
    option("--source", metavar="TEXT", help="Where the law is from."),
]
FILE_OF_MEASUREMENTS = [
    option(
        "--column", metavar="QUANTITY=NAME", multiple=True, help="Column of v, mu, F_t or F_n by name or number."
    ),
    option("--radius", metavar="M", help="Radius of the track, where the speed is in rpm."),
    option("--speeds", metavar="LOW:HIGH", type=_Range(half=True), help="Read rows of these speeds in m/s only."),
    option("--leave-out", is_flag=True, help="Leave out rows that are no measurements, and count them."),
    option("--keep-outliers", is_flag=True, help="Keep rows off a smooth curve, which are refused otherwise."),
]
"""How a file of measurements is read."""
LAW_NAMES: dict[str, Any] = {"metavar": "LAW", "shell_complete": _complete(_laws)}
"""What an argument or an option has that takes the name of a law, or a formula."""
LAW = [
    click.Argument(["law"], required=False, **LAW_NAMES),
    *DESCRIPTION,
    option("--from-csv", type=Path, metavar="FILE", help="Measured friction: v and mu, or v, F_t and F_n."),
    *FILE_OF_MEASUREMENTS,
    option("--extrapolate", is_flag=True, help="Hold the first and the last measured coefficient."),
    option("--parameter", "-p", metavar="NAME=VALUE", multiple=True, help="Value of a parameter of the law."),
]
POINT = [
    option("-V", "V", metavar="M/S", help=f"Belt speed ({PAPER['V']})."),
    option("-N", "N", metavar="N", help=f"Normal force ({PAPER['N']})."),
    option("-m", "m", metavar="KG", help=f"Mass ({PAPER['m']})."),
    option("-k", "k", metavar="N/M", help=f"Stiffness ({PAPER['k']})."),
    option(
        "--point", type=Path, metavar="FILE", multiple=True, help="TOML with law, V, N, m, k, c, [parameters]."
    ),
]
DAMPING = option("-c", "c", metavar="KG/S", help="Damping.")
CRITERION = option(
    "--criterion", metavar="NAME", default="least_squares", shell_complete=_complete(_criteria),
    help="least_squares, harmonic or equilibrium.",
)  # fmt: skip
CRITERIA = option(
    "--criterion", metavar="NAME", default="least_squares", help="least_squares, harmonic, equilibrium, or all.",
    shell_complete=_complete(lambda: [*_criteria(), "all"]),
)  # fmt: skip
METHOD = [
    option(
        "--method", metavar="NAME", default="auto", shell_complete=_complete(_methods), help="A method, or auto."
    ),
    option("--rtol", metavar="X", type=NUMBER, help="Relative error that is good enough (0.001)."),
]


def time_limit(text: str = "Seconds of computation.", default: float | None = None) -> click.Option:
    """Return the option that limits the time."""
    return option("--time-limit", metavar="S", type=NUMBER, default=default, help=text)
