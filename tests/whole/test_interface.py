"""What users build upon: public names, signatures, commands, options, and what JSON says of a result.

The list in `interface.txt` is frozen. A line is added with a minor version; one is changed or taken away with a
major version only, after it was deprecated. ``python tests/whole/test_interface.py`` writes the list anew.
"""

import inspect
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import get_args

import click

import stickslip_sym as ss
from stickslip_sym.cli.program import COMMANDS, program
from stickslip_sym.criteria.criterion import CriterionName
from stickslip_sym.motion.thresholds.methods import MethodName, methods

LIST = Path(__file__).with_name("interface.txt")


def signature(name, value):
    """Return a line: a name, and the names of what it takes with `*` and `/` as Python has them."""
    try:
        parameters = inspect.signature(value).parameters.values()
    except (TypeError, ValueError):
        return name
    bare = [
        one.replace(annotation=one.empty, default=one.empty if one.default is one.empty else ...)
        for one in parameters
    ]
    return f"{name}{inspect.Signature(bare)}".replace("Ellipsis", "...")


def in_json(one):
    """Return the attributes of a result that its JSON has."""
    own = [field.name for field in fields(one)] if is_dataclass(one) else []
    reported = getattr(one, "reported", own)
    return "by its kind" if isinstance(reported, property) else ", ".join(reported)


def interface():
    """Return every line of the list."""
    lines = []
    for name in sorted(ss.__all__):
        value = getattr(ss, name)
        lines.append(signature(f"ss.{name}", value) if inspect.isfunction(value) else f"ss.{name}")
    for name in sorted(ss.results.__all__):
        lines.append(f"ss.results.{name}: {in_json(getattr(ss.results, name))}")
    lines += [f"ss.laws.{name}" for name in sorted(ss.laws)]
    lines += [f"ss.criteria.{name}" for name in sorted(ss.criteria.catalogue)]
    for name in COMMANDS:
        command = program.get_command(click.Context(program), name)
        for parameter in command.params:
            written = [*parameter.opts, *parameter.secondary_opts]
            words = (
                " ".join(written)
                if isinstance(parameter, click.Option)
                else parameter.make_metavar(click.Context(command))
            )
            lines.append(f"stickslip {name} {words}")
    return lines


def test_what_users_build_upon_is_as_listed():
    listed = LIST.read_text(encoding="utf-8").splitlines()
    now = interface()
    assert [line for line in listed if line not in now] == [], "what was public is gone"
    assert [line for line in now if line not in listed] == [], "what is new is not in the list"
    assert len(listed) == len(now) > 250


def test_names_that_editors_offer_are_those_that_there_are():
    offered, _ = get_args(CriterionName)
    assert set(get_args(offered)) == set(ss.criteria.catalogue)
    offered, _ = get_args(MethodName)
    assert set(get_args(offered)) == {"auto", *methods()}


if __name__ == "__main__":
    LIST.write_text("\n".join(interface()) + "\n", encoding="utf-8")
