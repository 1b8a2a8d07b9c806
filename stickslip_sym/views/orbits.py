"""What is shown of limit cycles in pure slip."""

from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.views import dispatch, markup

_UNITS = {"amplitude": "m/s", "period": "s", "floquet": "1/s"}


@dispatch.notebook_html.register(LimitCycle)
def limit_cycle_as_html(cycle: LimitCycle) -> str:
    """Return a table of its quantities, under whether it is stable."""
    rows = [[name, f"{getattr(cycle, name):.9g}", unit] for name, unit in _UNITS.items()]
    kind = "stable" if cycle.stable else "unstable"
    return markup.html_table(["quantity", "value", "unit"], rows, caption=f"{kind} pure-slip limit cycle")
