"""Pages that need no script and nothing from elsewhere: well-formed HTML, formulas as MathML, figures as SVG.

Imports `core`. The study of an operating point and the report of the paper's checks are made with it; one more is
a list of sections for `document.page`, with a style sheet of its own where `page.css` does not serve.
"""
