"""How long parts of a call may take unless a user says otherwise; nothing is imported, as options name them."""

SECONDS_TO_DERIVE = 120.0  # for a closed form, where SymPy's integrator searches too
SECONDS_OF_PART = 20.0  # for a part of a study or of a page, or to find where a motion leads
