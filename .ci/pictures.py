#!/usr/bin/env python3
"""Compare README's pictures with what its commands draw now, by texts and numbers; with ``--draw`` draw them anew.

A picture of a page keeps the page's texts beside its pixels, in a chunk of text of the PNG. In the picture of
costs the places of the points are measured times, which are never the same: its texts alone are compared, after a
run that integrates a tenth of the time.
"""

import base64
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import zlib
from html import unescape
from pathlib import Path

from stickslip_sym.views.pages.browser import require_browser

ROOT = Path(__file__).parents[1]
TRADE, STUDY = ROOT / ".github" / "tradeoff.svg", ROOT / ".github" / "study.png"
SIZE, SCALE = (1067, 1345), 0.75  # of the picture of the study, in pixels of the page, and of a pixel of it
PATIENCE = "3000"  # seconds for each part of the study, and for all methods: none is left out on a busy machine
SHORTER = """
from stickslip_sym.comparison import tradeoff
tradeoff._TIME_OF_RUN /= 10
tradeoff.SCAN_STEP *= 10
tradeoff.SPEEDS = tradeoff.SPEEDS[9:10]
"""
FIGURES = 4  # of the study that the picture shows
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
TICK = re.compile(r"\$\\mathdefault\{.*\}\$")
SAME = 1e-3  # relative difference of two numbers that are shown
KEYWORD = b"Description\0"


def command_in_readme(name: str) -> list[str]:
    """Return the command under a picture, as README states it."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return shlex.split(re.search(rf"`stickslip ({name} [^`]*)`", text)[1].replace("\n", " "))


def run(arguments: list[str], folder: str, before: str = "") -> None:
    """Run the command as a user does, after some lines of Python."""
    program = f"{before}\nfrom stickslip_sym.cli.start import main; main()"
    subprocess.run([sys.executable, "-c", program, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def texts_of_svg(svg: str) -> list[str]:
    """Return the texts of a picture, of whatever is no tick; each stands in a comment before its paths."""
    found = [unescape(text).strip() for text in re.findall(r"<!--(.*?)-->", svg, re.S)]
    return [text for text in found if text and not NUMBER.fullmatch(text) and not TICK.fullmatch(text)]


def texts_of_study(page: str) -> list[str]:
    """Return the texts of the first part of a study: those of its head, its first pictures and their captions."""
    *shown, _ = page.split("</figcaption>", FIGURES)
    body = "</figcaption>".join(shown).partition("<body")[2].partition(">")[2]
    pictures = [base64.b64decode(data).decode() for data in re.findall(r"svg\+xml;base64,([^\"']+)", body)]
    words = [" ".join(unescape(text).split()) for text in re.sub(r"<(style|title).*?</\1>", "", body).split("<")]
    words = [text.partition(">")[2].strip() for text in words]
    return [text for text in words if text] + [text for svg in pictures for text in texts_of_svg(svg)]


def differences(kept: list[str], now: list[str]) -> list[str]:
    """Return the texts that differ, their numbers held against each other as numbers."""

    def parts(text: str) -> tuple[str, list[float]]:
        return NUMBER.sub("#", text), [float(number.replace("−", "-")) for number in NUMBER.findall(text)]

    def same(a: str, b: str) -> bool:
        (words, numbers), (others, values) = parts(a), parts(b)
        pairs = zip(numbers, values, strict=False)
        return words == others and all(abs(x - y) <= SAME * max(abs(x), abs(y)) for x, y in pairs)

    gone = [f"- {text}" for text in kept if not any(same(text, other) for other in now)]
    return gone + [f"+ {text}" for text in now if not any(same(text, other) for other in kept)]


def chunk(kind: bytes, data: bytes) -> bytes:
    """Return a chunk of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def kept_texts(png: bytes) -> list[str]:
    """Return the texts that a picture of a page keeps."""
    place = 8
    while place < len(png):
        (length,), kind = struct.unpack(">I", png[place : place + 4]), png[place + 4 : place + 8]
        data = png[place + 8 : place + 8 + length]
        if kind == b"zTXt" and data.startswith(KEYWORD):
            return zlib.decompress(data[len(KEYWORD) + 1 :]).decode().splitlines()
        place += 12 + length
    return []


def photograph(page: Path, texts: list[str]) -> bytes:
    """Return a picture of the first part of a page, with its texts."""
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder, "page.png")
        options = [
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            f"--user-data-dir={folder}/p",
        ]
        options += [f"--window-size={SIZE[0]},{SIZE[1]}", f"--force-device-scale-factor={SCALE}"]
        options += [f"--screenshot={picture}", page.as_uri()]
        subprocess.run([require_browser(), *options], check=True, capture_output=True, timeout=120)
        png = picture.read_bytes()
    text = chunk(b"zTXt", KEYWORD + b"\0" + zlib.compress("\n".join(texts).encode()))
    return png[:33] + text + png[33:]  # behind the signature and the first chunk


def main() -> None:
    """Compare, or draw anew."""
    draw, stale = sys.argv[1:] == ["--draw"], []
    with tempfile.TemporaryDirectory() as folder:
        run([*command_in_readme("study exponential"), "-o", "study.html", "--time-limit", PATIENCE], folder)
        page = Path(folder, "study.html")
        texts = texts_of_study(page.read_text(encoding="utf-8"))
        if draw:
            STUDY.write_bytes(photograph(page, texts))
        stale += differences(kept_texts(STUDY.read_bytes()), texts)
        before = "" if draw else SHORTER
        run([*command_in_readme("tradeoff exponential"), "--time-limit", PATIENCE], folder, before)
        svg = Path(folder, "trade.svg").read_text(encoding="utf-8")
        if draw:
            TRADE.write_text(svg, encoding="utf-8")
        stale += differences(texts_of_svg(TRADE.read_text(encoding="utf-8")), texts_of_svg(svg))
    if stale:
        raise SystemExit("\n".join(["README's pictures are stale; run .ci/pictures.py --draw:", *stale]))


if __name__ == "__main__":
    main()
