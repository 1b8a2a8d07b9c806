"""Pages that need nothing from elsewhere: well-formed HTML, formulas as MathML, figures as SVG.

The study of an operating point, the explorer and the report of the paper's checks are made with it; one more is a
template that extends ``page.html``, with a style sheet of its own beside it where `page.css` is not enough.
"""
