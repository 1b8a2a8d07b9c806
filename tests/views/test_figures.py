"""Every kind of picture: no text beyond its frame, and no legend over a curve."""

import numpy as np
import pytest

import stickslip_sym as ss

pytest.importorskip("matplotlib")
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def figures(made):
    """Yield one picture of each kind with its name."""
    law = made["law"]
    for name in ("map", "basins", "trajectory", "regime"):
        yield name, made[name].plot()
    yield "law", law.plot()
    yield "comparison", ss.results.Comparison("thresholds", made["study"].answers).plot()
    v = np.linspace(0.02, 1, 30)
    fits = ss.fit(v, law.mu(v) + 0.003 * np.cos(40 * v), laws=["exponential"])
    yield "fit", fits.plot()
    yield "measurements", fits.measured.plot()


def beyond(figure):
    """Return the texts that are drawn beyond the frame of a figure."""
    canvas, drawn = FigureCanvasAgg(figure), []
    with pytest.MonkeyPatch.context() as patched:
        draw = Text.draw
        patched.setattr(
            Text, "draw", lambda text, *given, **more: (drawn.append(text), draw(text, *given, **more))
        )
        canvas.draw()
    frame = figure.bbox.padded(1.0)
    texts = [text for text in drawn if text.get_visible() and text.get_text().strip()]
    return [text.get_text() for text in texts if not _within(text.get_window_extent(), frame)]


def _within(box, frame):
    return frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1


def covered(figure):
    """Return the share of the points of each curve that a legend of its panel covers, where there is any."""
    shares = {}
    for ax in figure.axes:
        legend = ax.get_legend()
        if legend is None:
            continue
        box = legend.get_window_extent()
        for line in ax.lines:
            points = line.get_transform().transform(line.get_path().interpolated(20).vertices)
            points = points[np.isfinite(points).all(axis=1)]
            inside = [box.contains(*point) for point in points]
            if len(points) and any(inside) and line.get_linestyle() != "None":
                shares[line.get_label()] = np.mean(inside)
    return shares


def test_pictures_have_their_texts_within_and_their_curves_beside_the_legend(of_each_kind):
    seen = set()
    for name, figure in figures(of_each_kind):
        assert beyond(figure) == [], name
        assert covered(figure) == {}, name
        seen.add(name)
    assert len(seen) == 8


def test_what_is_beyond_or_covered_is_noticed(of_each_kind):
    figure = of_each_kind["law"].plot()
    (ax,) = figure.axes
    figure.text(0.99, 0.5, "a text that is cut off")
    ax.legend(loc="center", bbox_to_anchor=(0.1, 0.6))
    FigureCanvasAgg(figure).draw()
    assert beyond(figure) == ["a text that is cut off"]
    assert covered(figure)["exponential"] > 0
