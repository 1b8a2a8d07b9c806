#!/usr/bin/env python3
"""Build the documentation in build/documentation: pages, gallery, and the reference from docstrings, by pdoc.

What is built needs no network: formulas are MathML, and the pictures are drawn here.
"""

import base64
import contextlib
import importlib
import inspect
import json
import re
import shutil
from pathlib import Path
from types import ModuleType

import pdoc.doc
import pdoc.render
from pygments.formatters import HtmlFormatter

import stickslip_sym as ss
from stickslip_sym.views.pages.render import math_element

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FOLDER = ROOT / "build" / "documentation"
DOCS = "stickslip_sym/docs"
PAGES = {
    "README.md": "index", f"{DOCS}/notebook.ipynb": "notebook", f"{DOCS}/tutorial.md": "tutorial",
    f"{DOCS}/instruments.md": "instruments", f"{DOCS}/systems.md": "systems", f"{DOCS}/methods.md": "methods",
    f"{DOCS}/gallery.md": "gallery", "derivations/paper.md": "derivation", "derivations/README.md": "proofs",
    "paper_checks/README.md": "paper_checks", "CHANGELOG.md": "changelog", "CONTRIBUTING.md": "contributing",
}  # fmt: skip
REFERENCE = [f"stickslip_sym{part}" for part in ("", ".model.laws", ".criteria", ".criteria.quadrature")]
PURPOSES = {
    "A law and an oscillator": "FrictionLaw Parameter laws Oscillator symbols save load",
    "Derive and prove": "derive Criterion criteria Status",
    "Evaluate": "slope_average quadrature enclose tradeoff",
    "Thresholds": "pure_slip_damping compare critical margins",
    "Motions": "simulate classify regime stick_slip_cycle limit_cycles peak_velocity motion_map basin_map "
    "basin_sweep Motion Outcome Phase",
    "Measurements": "read_measurements fit",
    "Decide, and hand on": "study export_latex export_code results",
    "Errors": "StickSlipError InputError NoClosedForm NoThreshold NotConverged OutOfTime InputWarning",
}
"""Public names by what one wants."""
DISPLAYED = re.compile(r"^\$\$(.+?)(?:\s*\\tag\{(\w+)\})?\$\$$", re.M)
PAIR = re.compile(r'(<div class="pdoc-code codehilite">(?:(?!</div>).)*</div>)\s*(<p><img [^>]*></p>)', re.S)
"""Code, and the picture that it draws."""


def displayed(match: re.Match) -> str:
    """Return a formula of its own line as MathML, with the number it has in the paper."""
    number = f" ({match[2]})" if match[2] else ""
    return f'<div class="formula">{math_element(match[1])}{number}</div>'


def text_of(path: str) -> str:
    """Return a document as Markdown; of a notebook the cells with what they gave, the pictures as files."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if not path.endswith(".ipynb"):
        return text
    parts, count = [], 0
    for cell in json.loads(text)["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if "image/png" in data:
                count += 1
                picture = FOLDER / f"{Path(path).stem}_{count}.png"
                picture.write_bytes(base64.b64decode(data["image/png"]))
                parts.append(f"![{source}]({picture.as_posix()})")
            else:
                parts.append(f"```text\n{''.join(output.get('text') or data['text/plain'])}\n```")
    return "\n\n".join(parts)


def page(path: str, name: str, linked: dict[str, str]) -> pdoc.doc.Module:
    """Return a document as a module with nothing but a docstring, its links to other pages and pictures mended."""
    text = DISPLAYED.sub(displayed, text_of(path))

    def mended(link: re.Match) -> str:
        place, mark, anchor = link[2].partition("#")
        target = (ROOT / path).parent.joinpath(place).resolve()
        if target.is_dir():
            return link[1]  # it is in the repository only
        if target.suffix in (".svg", ".png", ".v") and target.is_file() and target.parent != FOLDER:
            shutil.copy(target, FOLDER)
        page = PAGES.get(target.relative_to(ROOT).as_posix())
        return f"[{link[1]}]({f'{page}.html' if page else target.name}{mark}{anchor})"

    text = re.sub(r"\[([^]]+)\]\((?!https?:)([^)\s]+)\)", mended, text)
    if name == "index":
        text += reference(linked)
    return pdoc.doc.Module(ModuleType(name, text))


def reference(linked: dict[str, str]) -> str:
    """Return the public names by purpose, each with its sentence, and the classes of what functions return."""
    listed = [name for names in PURPOSES.values() for name in names.split()]
    if sorted(listed) != sorted(ss.__all__):
        raise SystemExit(f"not listed by purpose, or twice: {sorted(set(ss.__all__) ^ set(listed))}")
    lines = ["", "## Reference", ""]
    for purpose, names in PURPOSES.items():
        lines += [f"### {purpose}", "", "| name | |", "| --- | --- |"]
        for name in names.split():
            place = f"stickslip_sym.html#{name}"
            sentence = (inspect.getdoc(getattr(ss, name)) or "").partition("\n\n")[0].replace("\n", " ")
            lines.append(f"| [`{name}`]({linked.get(f'stickslip_sym.{name}', place)}) | {sentence} |")
        lines.append("")
    returned = [f"[{name}]({place})" for name, place in linked.items() if name in ss.results.__all__]
    return "\n".join([*lines, "### What they return", "", ", ".join(returned), ""])


def linked_within(text: str) -> str:
    """Return a page without links to what it does not show: members that a class has from a private one."""
    shown = set(re.findall(r'id="([^"]+)"', text))
    # What pdoc leaves empty, as a style draws it, has a name for those who hear the page.
    text = re.sub(r'(<a class="headerlink" href="#([^"]+)")>', r'\1 aria-label="link to \2">', text)
    return re.sub(r'<a href="#([^"]+)">(.*?)</a>', lambda link: link[0] if link[1] in shown else link[2], text)


def require_links(place: str, text: str) -> None:
    """Refuse a page with a link to a file that is not there."""
    links = {link.partition("#")[0] for link in re.findall(r'href="([^"$]+)"', text)}
    local = {link for link in links if link and not re.match(r"https?:|data:", link)}
    missing = {link for link in local if not (FOLDER / place).parent.joinpath(link).exists()}
    if missing:
        raise SystemExit(f"{place} links to what is not there: {', '.join(sorted(missing))}")


def draw() -> None:
    """Draw the gallery's pictures by its own lines."""
    names: dict[str, object] = {}
    with contextlib.chdir(FOLDER):
        for code in re.findall(
            r"^```python\n(.*?)^```", (ROOT / DOCS / "gallery.md").read_text("utf-8"), re.M | re.S
        ):
            exec(compile(code, "gallery.md", "exec"), names)


def main() -> None:
    """Build everything anew."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    draw()
    shown = {name: list(getattr(importlib.import_module(name), "__all__", ())) for name in REFERENCE}
    for name in ss.results.__all__:
        shown.setdefault(getattr(ss.results, name).__module__, []).append(name)
    file = {name: f"{name.replace('.', '/')}.html" for name in (*shown, *PAGES.values())}
    linked = {name: file[name] for name in REFERENCE}
    linked |= {one: f"{file[name]}#{one}" for name in shown if name not in REFERENCE for one in shown[name]}
    titles = {name: re.match(r"# (.+)", text_of(path))[1] for path, name in PAGES.items()}
    pdoc.render.configure(docformat="numpy", show_source=False, template_directory=HERE)
    pages = titles | {"stickslip_sym": "Reference"}
    dark = HtmlFormatter(style="github-dark").get_style_defs(".pdoc-code")
    pdoc.render.env.globals |= {"documents": set(titles), "titles": pages, "code_in_the_dark": dark}
    modules = {name: page(path, name, linked) for path, name in PAGES.items()}
    for name, public in shown.items():
        module = importlib.import_module(name)
        [getattr(module, one) for one in public]  # loads what is loaded when it is first used
        module.__all__ = public  # what pdoc shows of it
        modules[name] = pdoc.doc.Module(module)
    texts = {file[name]: pdoc.render.html_module(module, modules) for name, module in modules.items()}
    texts["gallery.html"] = PAIR.sub(r'<div class="pair">\1\2</div>', texts["gallery.html"])
    for place, text in (texts | {"search.js": pdoc.render.search_index(modules)}).items():
        (FOLDER / place).parent.mkdir(parents=True, exist_ok=True)
        (FOLDER / place).write_text(linked_within(text), encoding="utf-8")
    for place in file.values():
        require_links(place, (FOLDER / place).read_text(encoding="utf-8"))


main()
