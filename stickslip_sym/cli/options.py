"""The options of the commands, each declared once.

A command is a function of `Given`, which notes the options that are read: `Given.reject_unused` refuses an option
that does nothing here, so that none is dropped without a word.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

import stickslip_sym as ss
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.operating_point import PAPER

_PICTURES = (".svg", ".png", ".pdf")
_LARGEST_IN_SI = 10**20
"""Of a number in SI units, and its inverse the smallest: beyond, no table could be computed in doubles."""


class Given:
    """The options of a command, by their names, and which of them were read."""

    def __init__(self, context: click.Context) -> None:
        self._context = context
        self._read = {"overwrite", "json"}
        self.command = str(context.command.name)

    def __getitem__(self, name: str) -> Any:
        """Return the value of an option, which is used hereby; None where the command has no such option."""
        self._read.add(name)
        return self._context.params.get(name)

    def reject_unused(self) -> None:
        """Refuse options that were given and have not been read; commands ask before they begin to compute."""
        for parameter in self._context.command.params:
            name = str(parameter.name)
            is_given = self._context.get_parameter_source(name) is ParameterSource.COMMANDLINE
            if is_given and name not in self._read:
                option = max(parameter.opts, key=len)
                raise InputError(f"{option} does nothing here: nothing asked for depends on it; leave it out")


def command(*parameters: click.Parameter | Sequence[click.Parameter]) -> Callable[..., click.Command]:
    """Return a decorator that makes a function of `Given` the command of its file; its docstring is the help."""
    flat = [each for some in parameters for each in ([some] if isinstance(some, click.Parameter) else some)]
    flat.append(option("--json", is_flag=True, is_eager=True, help="Print JSON instead of text."))
    if any(each.metavar == "FILE" and each.type is click.STRING for each in flat):
        flat.append(option("--overwrite", is_flag=True, is_eager=True, help="Let files be replaced."))

    def made(function: Callable[[Given], None]) -> click.Command:
        name = function.__module__.rpartition(".")[2]
        run = click.pass_context(lambda context, **_: function(Given(context)))
        return click.Command(name, params=flat, help=function.__doc__, callback=run)

    return made


Reader = Callable[[str, str], Any]
"""From the text of an option, and its name, to its value."""


def option(*names: str, read: Reader | None = None, default: Any = None, **more: Any) -> click.Option:
    """Return an option that is given once at most, its text read by a function, or a flag or ``multiple`` one."""
    if more.get("multiple"):
        more["help"] += " May be repeated."
    if more.get("multiple") or more.get("is_flag"):
        return click.Option(names, **more)
    name = max(names, key=len)

    def value(context: click.Context, parameter: click.Parameter, texts: tuple[Any, ...]) -> Any:
        if len(texts) > 1:  # the last would win without a word
            raise InputError(f"{name} is given twice; give it once")
        text = texts[0] if texts else default
        if read is not None and isinstance(text, str):
            return read(text, name)
        return text

    kind = more.pop("cls", click.Option)
    made: click.Option = kind(names, multiple=True, callback=value, **more)
    return made


class _HelpWhenShown(click.Option):
    """An option whose help is made when it is shown, since that loads what completion does without."""

    def __init__(self, *names: Any, text: Callable[[], str], **more: Any) -> None:
        super().__init__(*names, **more)
        self._text = text

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the two columns of the help."""
        self.help = self._text()
        return super().get_help_record(ctx)


def read_pairs(texts: Sequence[str], example: str) -> dict[str, str]:
    """Read NAME=VALUE texts; the example is for the refusal."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise InputError(f"{text!r} is not NAME=VALUE; write for example {example}")
        if name in values:
            raise InputError(f"{name} is given twice, as {values[name]} and {value}; give it once")
        values[name] = value
    return values


def pairs(
    *names: str, text: str, example: str, metavar: str = "NAME=VALUE", shell_complete: Any = None
) -> click.Option:
    """Return an option that takes NAME=VALUE, and may be repeated; its value is a dictionary."""
    return option(
        *names, metavar=metavar, multiple=True, help=text, shell_complete=shell_complete,
        callback=lambda *given: read_pairs(given[2], example),
    )  # fmt: skip


def read_number(text: Any, name: str) -> float:
    """Read a number as people write one, such as 0.5, 1e-3 or 1/3, of a size that an operating point may have."""
    from stickslip_sym.core.numbers import fraction

    value = fraction(text, name)
    if value and not 1 <= abs(value) * _LARGEST_IN_SI <= _LARGEST_IN_SI**2:
        raise InputError(
            f"{name} is too {'large' if abs(value) > 1 else 'small'}; "
            f"give a size from {1 / _LARGEST_IN_SI:g} to {_LARGEST_IN_SI:g} in SI units"
        )
    return float(value)


def read_range(text: str, name: str, *, of: str, unit: str | None = None, half: bool = False) -> tuple[Any, ...]:
    """Read LOW:HIGH, values of a quantity in SI units or others; where `half` is true either may be left out."""
    from stickslip_sym.core.units import share_unit, si_number

    ends = text.split(":")
    if len(ends) != 2 or (not half and not all(ends)):
        raise InputError(f"{name} {text[:60]!r} is not LOW:HIGH; write for example {name} 0.1:10")
    if all(ends):
        ends[0] = share_unit(ends[1], ends[0])
    return tuple(read_number(si_number(end, of, unit), name) if end else None for end in ends)


def unit_of_option(law: ss.FrictionLaw, name: str) -> str | None:
    """Return the unit that numbers of a quantity or a parameter may have: empty for any, None for its own."""
    if name in law.parameters:
        return law.parameters[name].unit or ""
    return None


def read_file(text: str, name: str, *, endings: Sequence[str]) -> Path:
    """Read the name of a file to write, and refuse it before the work where it cannot be written."""
    from stickslip_sym.output import files
    from stickslip_sym.views import drawing

    path = Path(text)
    if text.startswith("-"):
        raise InputError(f"{name} {text}: an option is no name of a file; write {name} FILE, or ./{text}")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {text!r}: there is no folder {str(path.parent)!r}; make it first")
    if endings and path.suffix.lower() not in endings:
        raise InputError(f"{name} {path}: its ending is none of {', '.join(endings)}")
    if endings is _PICTURES:
        drawing.require_matplotlib()
    given = click.get_current_context().params
    if given.get("json") and text == "/dev/stdout":
        raise InputError(f"{name} {text} and --json would print into each other; give {name} a file")
    if not given.get("overwrite") and files.is_kept(path):
        raise InputError(f"{text!r} exists: name another file by {name}, or add --overwrite to replace it")
    return path


def file_option(*names: str, endings: Sequence[str] = (), **more: Any) -> click.Option:
    """Return an option that takes the name of a file to write, of certain endings."""
    return option(*names, read=partial(read_file, endings=endings), metavar="FILE", **more)


def plot_option(text: str) -> click.Option:
    """Return the option that takes the name of a picture."""
    return file_option("--plot", endings=_PICTURES, help=f"{text} (SVG, PNG or PDF).")


def time_limit_option(text: str = "Seconds of computation.", default: float | None = None) -> click.Option:
    """Return the option that limits the time."""
    return option("--time-limit", metavar="S", read=read_number, default=default, help=text)


def criterion(*more: str) -> click.Option:
    """Return the option that names a criterion, or one of more words."""

    def names() -> list[str]:
        return [*ss.criteria.catalogue, *more]

    return option(
        "--criterion", cls=_HelpWhenShown, metavar="NAME", default="least_squares",
        help="A criterion (least_squares).", shell_complete=_complete(names),
        text=lambda: f"{', '.join(names())} (least_squares).",
    )  # fmt: skip


def _complete(names: Callable[[], Iterable[str]]) -> Callable[..., list[str]]:
    return lambda context, parameter, begun: [name for name in names() if name.startswith(begun)]


def _law_names() -> list[str]:
    from stickslip_sym.model.catalogue import ENTRIES

    return [entry.name for entry in ENTRIES]


def _parameters_of(context: click.Context) -> list[str]:
    """Return the beginnings of values for the law that was named, or for every law where it is another."""
    from stickslip_sym.model.catalogue import ENTRIES

    words = {context.params.get("law"), *context.args}  # where an option still lacks its value, all words are args
    named = [entry for entry in ENTRIES if entry.name in words] or ENTRIES
    return [f"{name}=" for name in dict.fromkeys(name for entry in named for name in entry.parameters.split())]


def complete_quantities(context: click.Context, parameter: click.Parameter, begun: str) -> list[str]:
    """Return what a quantity may be called: V, N, m, k, c, or a parameter of the law."""
    names = [*"VNmkc", *(text.removesuffix("=") for text in _parameters_of(context))]
    return [name for name in names if name.startswith(begun)]


def _methods() -> list[str]:
    from stickslip_sym.motion.thresholds.methods import methods

    return [*methods(), "auto"]


DESCRIPTION = [
    option("--static", metavar="MU", help="Static coefficient above mu(0+): a number or a formula."),
    option("--name", metavar="NAME", help="Name of a formula or of points."),
    pairs("--unit", text="Unit of a formula's parameter.", example="--unit alpha=s/m", metavar="NAME=UNIT"),
    option("--source", metavar="TEXT", help="Where the law is from."),
]
FILE_OF_MEASUREMENTS = [
    pairs(
        "--column", text="Column of v, mu, F_t or F_n by name or number.", metavar="QUANTITY=NAME",
        example='--column mu="Friction Factor"',
    ),
    option("--radius", metavar="M", help="Radius of the track, where the speed is in rpm."),
    option(
        "--speeds", metavar="LOW:HIGH", read=partial(read_range, of="speeds", half=True),
        help="Read rows of these speeds only, like 10:400 mm/s.",
    ),
    option("--leave-out", is_flag=True, help="Leave out rows that are no measurements, and count them."),
    option(
        "--bins", metavar="N", type=int,
        help="Average the rows in so many bins of speed.",
    ),
    option(
        "--block", metavar="N", type=int, multiple=True,
        help="Read this block only, of a file with several tables; repeatable.",
    ),
    option("--keep-outliers", is_flag=True, help="Keep rows off a smooth curve, which are refused otherwise."),
]  # fmt: skip
"""How a file of measurements is read."""
LAW_NAMES: dict[str, Any] = {"metavar": "[LAW]", "shell_complete": _complete(_law_names)}
"""What an argument or an option has that takes the name of a law, or a formula."""
PARAMETER = pairs(
    "--parameter",
    "-p",
    text="Value of a parameter of the law.",
    example="-p alpha=3",
    shell_complete=lambda context, _, begun: [one for one in _parameters_of(context) if one.startswith(begun)],
)
AT = [
    click.Argument(["law"], required=False, **LAW_NAMES),
    *DESCRIPTION,
    option("--from-csv", type=Path, metavar="FILE", help="Measured friction: v and mu, or v, F_t and F_n."),
    *FILE_OF_MEASUREMENTS,
    option("--extrapolate", is_flag=True, help="Hold the first and the last measured coefficient."),
    PARAMETER,
    option("-V", "V", metavar="M/S", help=f"Belt speed ({PAPER['V']})."),
    option("-N", "N", metavar="N", help=f"Normal force ({PAPER['N']})."),
    option("-m", "m", metavar="KG", help=f"Mass ({PAPER['m']})."),
    option("-k", "k", metavar="N/M", help=f"Stiffness ({PAPER['k']})."),
    option(
        "--point", type=Path, metavar="FILE", multiple=True, help="TOML with law, V, N, m, k, c, [parameters]."
    ),
]
"""The law and the operating point, with which every answer begins."""
DAMPING = option("-c", "c", metavar="KG/S", help="Damping.")
METHOD = [
    option(
        "--method", metavar="NAME", default="auto", shell_complete=_complete(_methods), help="A method, or auto."
    ),
    option(
        "--rtol", metavar="X", read=read_number, default=1e-3, help="Relative error that is good enough (0.001)."
    ),
]
