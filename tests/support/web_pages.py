"""Pages as readers of XML and a browser see them."""

import json
import re
import subprocess
from xml.etree import ElementTree

import pytest

from stickslip_sym.views.pages.browser import find_browser

XHTML = {"m": "http://www.w3.org/1998/Math/MathML"}


def check_well_formed(page):
    """XML reads it, it refers to nothing outside, and it needs no script; returns its root."""
    root = ElementTree.fromstring(page.removeprefix("<!DOCTYPE html>\n"))
    assert root.get("lang") == "en"
    assert root.findtext("head/title")
    ids = [node.get("id") for node in root.iter() if node.get("id")]
    assert len(ids) == len(set(ids))
    references = [node.get("href") for node in root.iter() if node.get("href")]
    assert {name[1:] for name in references if name.startswith("#")} <= set(ids)
    sources = [name for name in references if not name.startswith(("#", "certificates/"))]  # written beside it
    sources += [node.get("src") for node in root.iter() if node.get("src")]
    assert all(source.startswith("data:") for source in sources)
    assert not list(root.iter("script"))
    assert "url(" not in page
    return root


def browse(address, tmp_path):
    command = [
        find_browser(), "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-sync",
        "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-quic",
        "--enable-logging=stderr", "--v=0", f"--user-data-dir={tmp_path / 'profile'}", "--window-size=1300,900",
        "--dump-dom", address,
    ]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def require_browser(tmp_path):
    """Skip what follows where no browser is, or it cannot start."""
    if find_browser() is None:
        pytest.skip("all but the browser's part: no chromium on this machine (Debian: apt-get install chromium)")
    code = _code_of_an_empty_page(tmp_path)
    if code < 0:  # where memory for addresses is limited, chromium stops with SIGTRAP at any page
        pytest.skip(f"all but the browser's part: chromium cannot show an empty page here (signal {-code})")


_codes = list[int]()


def _code_of_an_empty_page(tmp_path):
    if not _codes:  # once in each process
        _codes.append(browse("about:blank", tmp_path).returncode)
    return _codes[0]


WIDTHS = (1200, 360)
_PROBE = """<script>
addEventListener("load", () => {
  const root = document.documentElement, height = node => node.getBoundingClientRect().height;
  const rows = [...document.querySelectorAll("tbody.claim")];
  const result = {
    width: innerWidth,
    overflow: root.scrollWidth - root.clientWidth,
    rows: rows.length,
    shown: rows.filter(row => height(row) > 20).length,
    formulas: [...document.querySelectorAll("math")].map(height),
    pictures: [...document.images].map(image => [image.complete, image.naturalWidth, height(image)]),
  };
  parent.postMessage(JSON.stringify(result), "*");
});
</script></body>"""
_SEVERAL = """<!DOCTYPE html><title>the page in several widths</title><script>
addEventListener("message", event => {
  const node = document.createElement("pre");
  node.textContent = event.data;
  document.body.append(node);
});
</script>"""


def sent_by(frames, tmp_path):
    """Return the messages that pages in frames send, as text of HTML; one start of the browser shows all."""
    file = tmp_path / "several.html"
    file.write_text("\n".join([_SEVERAL, *frames]), encoding="utf-8")
    done = browse(file.as_uri(), tmp_path)
    assert (done.returncode, ":CONSOLE" in done.stderr) == (0, False), done.stderr
    return re.findall(r"<pre>(.*?)</pre>", done.stdout)


def look_at(page, tmp_path):
    """Return what a browser shows of a page in frames of several widths: nothing overflows, pictures are drawn."""
    require_browser(tmp_path)
    (tmp_path / "probed.html").write_text(page.replace("</body>", _PROBE), encoding="utf-8")
    frames = [f'<iframe src="probed.html" width="{width}" height="900"></iframe>' for width in WIDTHS]
    probes = [json.loads(text) for text in sent_by(frames, tmp_path)]
    assert sorted(probe["width"] for probe in probes) == sorted(WIDTHS)
    for probe in probes:
        assert probe["overflow"] <= 0
        assert all(done and natural > 100 and height > 100 for done, natural, height in probe["pictures"])
    return probes
