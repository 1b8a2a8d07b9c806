"""The table of languages. It imports nothing large, for the command line shows it."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from stickslip_sym.output.sections import sections

_HERE = Path(__file__).parent


@dataclass(frozen=True)
class Language:
    """A language: its words, and its page of text.

    The page is sections that begin with "@@ section", with $fields. An argument's name begins with none of
    `prefixes`, and is none of the page's words.
    """

    name: str
    description: str
    file: Path
    prefixes: tuple[str, ...] = ()
    argument: str = "a[{}]"  # inside a term, with {} for its number
    first: int = 0  # number of an argument
    declared: str = "{}"  # an argument in the head of a function
    power: str = "pow({}, {})"
    nan: str = "NAN"
    infinity: str = "HUGE_VAL"
    functions: tuple[tuple[str, str], ...] = ()  # of SymPy, that its printer does not know, and their names
    comment: str = ""  # what a line of a comment begins with
    next_line: str = ",\n    "  # between numbers that stand on two lines
    next_row: str = ",\n    "  # between the rows of a table
    never: tuple[str, ...] = ()  # in a comment
    elementwise: bool = False  # products and quotients of arrays have operators of their own
    main_first: bool = False  # the functions that are called from outside stand before what they use

    @cached_property
    def page(self) -> dict[str, str]:
        """The sections of the page by their names."""
        return sections(self.file)

    @cached_property
    def words(self) -> frozenset[str]:
        """Names that an argument cannot have."""
        return frozenset(self.page["words"].split())


LANGUAGES = {
    "python": Language(
        "python",
        "A NumPy module.",
        _HERE / "python.txt",
        power="numpy.power({}, {})",
        nan="numpy.nan",
        infinity="1e999",  # a parameter may be called numpy
        functions=(("erf", "_erf"), ("erfc", "_erfc")),
        next_row="],\n    [",
        never=("\\", '"""'),
    ),
    "c": Language(
        "c",
        "C99; it needs libm only.",
        _HERE / "c.txt",
        prefixes=("M_", "FP_"),  # of macros
        declared="double {}",
        comment="   ",
        never=("*/",),
    ),
    "octave": Language(
        "octave",
        "Octave or MATLAB.",
        _HERE / "octave.txt",
        argument="a{{{}}}",
        first=1,
        power="({}).^({})",
        elementwise=True,
        nan="NaN",
        infinity="Inf",
        functions=(("expm1", "expm1"), ("log1p", "log1p")),
        comment="% ",
        next_line=", ...\n    ",
        next_row="; ...\n    ",
        main_first=True,
    ),
    "javascript": Language(
        "javascript",
        "JavaScript, for a page.",
        _HERE / "javascript.txt",
        power="Math.pow({}, {})",
        nan="NaN",
        infinity="Infinity",
        functions=(("erf", "erf"), ("erfc", "erfc"), ("expm1", "Math.expm1"), ("log1p", "Math.log1p")),
        comment="   ",
        never=("*/",),
    ),
}
"""Languages by name. One that is put here is known by its name, and an option of the command, from then on."""
