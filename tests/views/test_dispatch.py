"""How a view is chosen: by the class of a result, or the one that it extends, in a module loaded for it."""

import pytest

import stickslip_sym as ss
from stickslip_sym.output.shown import Drawn, Report, Shown, views_of
from stickslip_sym.views import dispatch


def shown_classes():
    """Return the classes of results that notebooks show."""
    classes, left = set(), [Shown]
    while left:
        found = left.pop().__subclasses__()
        classes.update(found)
        left += found
    return [one for one in classes - {Report, Drawn} if one.__module__.startswith("stickslip_sym.")]


def test_every_result_that_is_drawn_or_told_has_its_own_view():
    names = ss.results.__all__  # which loads them
    classes = [one for one in shown_classes() if one.__name__ in names]
    assert len(classes) > 20
    for one in classes:
        dispatch.load_views(one)
        if issubclass(one, Report):
            assert {view.dispatch(one) for view in (dispatch.plain_text, dispatch.parts)} - {
                view.dispatch(object) for view in (dispatch.plain_text, dispatch.parts)
            }, one
        if issubclass(one, Drawn):
            assert {view.dispatch(one) for view in (dispatch.draw, dispatch.figure)} - {
                view.dispatch(object) for view in (dispatch.draw, dispatch.figure)
            }, one


def test_a_class_of_a_user_is_shown_as_the_one_that_it_extends():
    class Lubricated(ss.FrictionLaw):
        pass

    law = Lubricated("0.3 - 0.1*v", name="oil")
    assert repr(law) == repr(ss.FrictionLaw("0.3 - 0.1*v", name="oil"))
    assert "oil" in law._repr_html_()


def test_what_has_no_view_of_its_own_is_one_sentence():
    verdict = ss.derive("mu_s - a*v").verdict
    assert views_of(verdict).notebook_html(verdict).count("<p") == 1
    assert str(verdict) in verdict._repr_html_()


@pytest.mark.parametrize("view", [dispatch.one_line, dispatch.notebook_latex, dispatch.page])
def test_a_view_that_there_is_not_is_refused(view):
    with pytest.raises(TypeError, match=r"(of|for) a int"):
        view(3)
