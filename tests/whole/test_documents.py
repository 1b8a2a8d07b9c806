"""The code and the commands of every document are run, and print what they say."""

import contextlib
import io
import json
import re
import runpy
import shlex
import shutil
import subprocess
import tomllib
from collections import Counter
from pathlib import Path

import pytest

import stickslip_sym as ss
from support import notebooks
from support.commands import inside

ROOT = Path(__file__).parents[2]
PACKAGE = Path(ss.__file__).parent
"""In the checkout, or where a wheel was installed: then its documents are there, and the others may be nowhere."""
DERIVATION = "derivations/paper.md"
DOCS = "stickslip_sym/docs"
GALLERY = f"{DOCS}/gallery.md"
FILES = {
    name: (PACKAGE.parent if name.startswith(DOCS) else ROOT) / name
    for name in (
        "README.md", "CONTRIBUTING.md", f"{DOCS}/tutorial.md", f"{DOCS}/instruments.md", f"{DOCS}/systems.md",
        f"{DOCS}/methods.md", GALLERY, "derivations/README.md", DERIVATION, "paper_checks/README.md",
    )
}  # fmt: skip
DOCUMENTS = {name: file.read_text(encoding="utf-8") for name, file in FILES.items() if file.is_file()}
in_checkout = pytest.mark.skipif(DOCUMENTS.keys() != FILES.keys(), reason="needs the documents of a checkout")
TIME = re.compile(r"\b[\d.]+ (ns|us|ms|s)\b")
ROUNDING = re.compile(r"\b\d\.\de-1[4-9]\b")
PATH = re.compile(r"`([\w./]+(?:/|\.py|\.md|\.cff))`|\]\(([\w./]+)\)")


def blocks(language, names=DOCUMENTS):
    """Return the documents and their blocks of a language."""
    return [
        (name, text)
        for name in names
        if name in DOCUMENTS
        for text in re.findall(rf"^```{language}\n(.*?)^```", DOCUMENTS[name], re.M | re.S)
    ]


def comparable(text):
    """Replace what differs between machines: measured times, and errors of a few units in the last place."""
    return [ROUNDING.sub("ROUNDING", TIME.sub("TIME", line)).rstrip() for line in text.strip().splitlines()]


def printed(code, names):
    """Run a block and return the lines that it prints; what it defines goes into `names`."""
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(code, "a block of a document", "exec"), names)
    return stream.getvalue().splitlines()


def stated(code):
    """Return what a block says that it prints: comments that are lines of their own."""
    return re.findall(r"^# (.*)$", code, re.M)


@pytest.mark.parametrize(("name", "code"), blocks("python", sorted({*DOCUMENTS} - {DERIVATION, GALLERY})))
def test_python_blocks_print_what_they_say(name, code, tmp_path, monkeypatch):
    """Away from the repository, for a block may write files."""
    monkeypatch.chdir(tmp_path)
    assert printed(code, {}) == stated(code)


@in_checkout
def test_derivation_prints_what_it_says():
    """In plain SymPy: this package enters in the last cell only."""
    cells = [cell for _, cell in blocks("python", [DERIVATION])]
    names = {}
    for cell in cells:
        assert printed(cell, names) == stated(cell)
    assert ["stickslip_sym" in cell for cell in cells] == [False] * (len(cells) - 1) + [True]


SESSIONS = [
    (name, command, output)
    for name, text in blocks("console")
    for command, output in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", text, re.M)
]


def module_inside(option, module, *arguments):
    """Run ``python -m MODULE`` in this process; the result is that of a process."""
    assert option == "-m"
    out = io.StringIO()
    with pytest.MonkeyPatch.context() as patched, contextlib.redirect_stdout(out):
        patched.setattr("sys.argv", [module, *arguments])
        with pytest.raises(SystemExit) as end:
            runpy.run_module(module, run_name="__main__", alter_sys=True)
    return subprocess.CompletedProcess((module, *arguments), end.value.code, out.getvalue(), "")


@pytest.mark.parametrize(("name", "command", "output"), SESSIONS)
def test_console_blocks_print_what_they_say(name, command, output, tmp_path):
    program, *arguments = shlex.split(command)
    done = inside(*arguments, cwd=tmp_path) if program == "stickslip" else module_inside(*arguments)
    assert done.returncode == 0, done.stderr
    assert comparable(done.stdout) == comparable(output)


@in_checkout
def test_documents_have_what_the_tests_run():
    shown = {
        "README.md",
        "CONTRIBUTING.md",
        f"{DOCS}/tutorial.md",
        f"{DOCS}/instruments.md",
        f"{DOCS}/systems.md",
        DERIVATION,
    }
    assert {name for name, _ in blocks("python")} >= shown
    assert {name for name, _ in blocks("console")} == {"README.md", f"{DOCS}/methods.md", "derivations/README.md"}
    setups = [line for _, text in blocks("sh", ["README.md"]) for line in text.splitlines()]
    assert len(setups) == 2
    assert setups[0].endswith("stickslip derive exponential")
    assert setups[1].endswith("pytest")
    assert len(DOCUMENTS["README.md"].splitlines()) <= 170  # three screens


@in_checkout
@pytest.mark.parametrize("name", sorted({*DOCUMENTS} - {GALLERY}))
def test_files_that_a_document_names_exist(name):
    """From its own folder, from the top, or from the package."""
    named = {code or link for code, link in PATH.findall(DOCUMENTS[name])}
    bases = (FILES[name].parent, ROOT, PACKAGE)
    assert named
    assert {path for path in named if not any((base / path).exists() for base in bases)} == set()


def test_gallery_draws_its_pictures(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    names = {}
    for _, code in blocks("python", [GALLERY]):
        assert printed(code, names) == stated(code) == []
    drawn = {path.name for path in tmp_path.iterdir() if path.stat().st_size > 5000}
    assert drawn == set(re.findall(r"\((\w+\.svg)\)", DOCUMENTS[GALLERY]))


def test_the_notebook_gives_what_it_keeps(monkeypatch):
    """Its pictures are figures, and its text is the same; in the folder of its data."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(PACKAGE / "docs")
    notebook, names = json.loads(Path("notebook.ipynb").read_text(encoding="utf-8")), {}
    cells = notebooks.code_cells(notebook)
    for cell in cells:
        kept = cell["outputs"]
        now = notebooks.outputs(*notebooks.run("".join(cell["source"]), names), cell["execution_count"])
        assert notebooks.text_of(now) == notebooks.text_of(kept)
        assert [*map(has_picture, now)] == [*map(has_picture, kept)]
    assert sum(has_picture(output) for cell in cells for output in cell["outputs"]) == 3


@pytest.mark.thorough
def test_the_notebook_gives_the_same_in_a_kernel(tmp_path):
    """What Jupyter shows of a cell is what is kept of it: one text, or one picture."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    for name in ("notebook.ipynb", "disc.csv"):
        shutil.copy(PACKAGE / "docs" / name, tmp_path)
    kept = nbformat.read(tmp_path / "notebook.ipynb", as_version=4)
    shown = nbformat.read(tmp_path / "notebook.ipynb", as_version=4)
    where = {"metadata": {"path": str(tmp_path)}}
    client = nbclient.NotebookClient(shown, timeout=300, coalesce_streams=True, resources=where)
    client.execute()
    for before, now in zip(notebooks.code_cells(kept), notebooks.code_cells(shown), strict=True):
        kinds = [[output["output_type"] for output in cell["outputs"]] for cell in (before, now)]
        assert kinds[0] == kinds[1]
        assert [*map(has_picture, now["outputs"])] == [*map(has_picture, before["outputs"])]
        if not any(map(has_picture, now["outputs"])):
            assert notebooks.text_of(now["outputs"]) == notebooks.text_of(before["outputs"])


def has_picture(output):
    return "image/png" in output.get("data", {})


@in_checkout
def test_the_claim_table_says_what_is_on_record():
    from paper_checks.claims import CLAIMS

    rows = re.findall(r"^\| ([A-Z]\d[^|]*) \| ([^|]*) \|", DOCUMENTS["paper_checks/README.md"], re.M)
    stated = {claim: verdict for ids, verdict in rows for claim in ids.split(", ")}
    on_record = {claim.id: claim.outcome.value.split(" with a ")[-1] for claim in CLAIMS.values()}
    assert stated == {claim: verdict.replace("qualification", "qualified") for claim, verdict in on_record.items()}
    counts = Counter(stated.values())
    for name in ("README.md", "paper_checks/README.md"):
        assert f"{len(stated)} of them, of which {counts['reproduced']} are reproduced" in DOCUMENTS[name]


@in_checkout
def test_the_citation_is_of_this_project():
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    stated = dict(re.findall(r"^([a-z-]+):(?: (.+))?$", "\n".join(lines), re.M))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {"cff-version", "message", "title", "authors", "references"} <= set(stated)
    assert (stated["title"], stated["license"]) == (project["name"], project["license"])
    assert (stated["version"], stated["abstract"]) == (ss.__version__, project["description"])
    listed = [f"name: {author['name']}" for author in project["authors"]] + project["keywords"]
    assert {f"  - {entry}" for entry in listed} <= set(lines)
