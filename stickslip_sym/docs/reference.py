"""Which classes the reference documents beside the public names: those of what public functions return."""

import importlib
import pkgutil
import re

import stickslip_sym as ss


def results() -> dict[str, list[str]]:
    """Return the classes to which annotations of public functions lead, by module; they are no public names."""
    modules = [importlib.import_module(one.name) for one in pkgutil.walk_packages(ss.__path__, "stickslip_sym.")]
    classes: dict[str, type] = {}
    for module in modules:
        for name, one in vars(module).items():
            if isinstance(one, type) and one.__module__ == module.__name__ and not name.startswith("_"):
                classes.setdefault(name, one)
    found: dict[str, list[str]] = {}
    todo = [getattr(ss, name) for name in vars(ss)["__all__"]]
    for one in todo:  # it grows
        members = vars(one).values() if isinstance(one, type) else [one]
        functions = [getattr(member, "fget", None) or getattr(member, "func", member) for member in members]
        hints = [getattr(function, "__annotations__", {}).get("return") for function in functions]
        fields = vars(one).get("__annotations__") if isinstance(one, type) else None
        for name in re.findall(r"\w+", f"{hints} {fields}"):
            if name in classes and classes[name] not in todo:
                todo.append(classes[name])
                found.setdefault(classes[name].__module__, []).append(name)
    return found
