"""Limits by which rows are judged: for each a row, a column or a law on either side."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr

import stickslip_sym as ss
from stickslip_sym.comparison.decision import Decision
from stickslip_sym.model.fitting import fit as fitting
from stickslip_sym.model.fitting import weights as weighing
from stickslip_sym.model.fitting.averaged import Averaged, ByLaw
from stickslip_sym.model.fitting.lack_of_fit import chance_of_residuals, polynomials_of_rank
from stickslip_sym.model.fitting.least_squares import Problem
from stickslip_sym.model.fitting.result import Fit
from stickslip_sym.model.measured import heavy_tails, sweep_branches
from stickslip_sym.model.measured.blocks import varying
from stickslip_sym.model.measured.columns import HeaderColumn
from stickslip_sym.model.measured.heavy_tails import have_heavy_tails
from stickslip_sym.model.measured.measurements import Measurements, _outliers
from stickslip_sym.model.measured.noise import correlation_of, last_decimal
from stickslip_sym.model.measured.plain import plain_numbers
from stickslip_sym.model.measured.proposals import _unit_of_speed
from stickslip_sym.model.measured.sweep_branches import sweep_branches_of

V = np.linspace(0.05, 1.2, 40)
LAW = ss.laws.exponential.typical()


def write(folder, *lines):
    path = folder / "rows.csv"
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(("largest", "varies"), [(1.05, False), (1.2, True)])
def test_columns_that_vary_by_a_tenth_are_named(largest, varies):
    assert bool(varying(["p"], [["1"], [str(largest)]])) == varies


def test_a_few_columns_that_vary_are_named():
    for count in (3, 12):
        named = varying([f"p{i}" for i in range(count)], [["1"] * count, ["2"] * count])
        assert len(named) == count if count == 3 else 3 < len(named) < 9


@pytest.mark.parametrize(("share", "agree"), [(0.9, True), (0.6, False)])
def test_blocks_agree_within_a_fifth(tmp_path, share, agree):
    blocks = [[f"{v:.4f},{part * LAW.mu(v):.5f}" for v in V[::4]] for part in (1.0, share)]
    path = write(tmp_path, "Step 1", "v [m/s],mu", *blocks[0], "", "Step 2", "v [m/s],mu", *blocks[1])
    if agree:
        assert len(ss.read_measurements(path)) == 20
    else:
        with pytest.raises(ss.InputError, match="contradict each other"):
            ss.read_measurements(path)


@pytest.mark.parametrize(("count", "heavy"), [(150, False), (450, True)])
def test_tails_are_told_where_rows_are_many(count, heavy):
    rng = np.random.default_rng(3)
    v = np.linspace(0.05, 1, count)
    assert have_heavy_tails(v, LAW.mu(v) + 0.004 * rng.standard_t(2.5, size=count)) == heavy


@pytest.mark.parametrize(("mu", "is_taken"), [(3.0, True), (9.0, False)])
def test_a_coefficient_is_below_some_units(mu, is_taken):
    if is_taken:
        assert Measurements.of([0.1, 0.2], [0.3, mu]).mu[1] == mu
    else:
        with pytest.raises(ss.InputError, match="a coefficient of friction is below"):
            Measurements.of([0.1, 0.2], [0.3, mu])


@pytest.mark.parametrize(("fastest", "is_taken"), [(60, True), (200, False)])
def test_speeds_without_a_unit_are_of_this_world(tmp_path, fastest, is_taken):
    path = write(tmp_path, "v,mu", "1,0.4", "2,0.35", f"{fastest},0.3")
    if is_taken:
        assert ss.read_measurements(path).v[-1] == fastest
    else:
        with pytest.raises(ss.InputError, match="without a unit a speed is in m/s"):
            ss.read_measurements(path)


@pytest.mark.parametrize(("radius", "is_taken"), [(0.5, True), (2, False), ("2 m", True), ("3000 m", False)])
def test_a_track_is_no_longer_than_a_room(tmp_path, radius, is_taken):
    path = write(tmp_path, "n [rpm],mu", "10,0.4", "20,0.35")
    if is_taken:
        assert len(ss.read_measurements(path, radius=radius)) == 2
    else:
        with pytest.raises(ss.InputError, match=r"no track|would be in m"):
            ss.read_measurements(path, radius=radius)


@pytest.mark.parametrize(("decimals", "last"), [(6, 1e-6), (13, 0.0)])
def test_long_decimals_were_computed(decimals, last):
    assert last_decimal(LAW.mu(V).round(decimals)) == pytest.approx(last, abs=0)


def test_noise_is_correlated_up_to_four_rows_apart():
    rng = np.random.default_rng(1)
    lags = []
    for apart in (1, 2, 4, 6):
        series = np.zeros((200 // apart + 1, apart))
        for i in range(1, len(series)):
            series[i] = 0.8 * series[i - 1] + rng.normal(size=apart)
        lags.append(correlation_of(series.ravel(), 0)[2])
    assert (lags[0], lags[2]) == (1, 4)
    assert lags[1] in (2, 3, 4), "a higher order may say more"
    assert lags[3] <= 4


def test_few_rows_are_not_correlated():
    """One lag needs eight: in five rows that fall and rise again nothing is correlated, in twenty there is."""
    for count, correlated in ((5, False), (20, True)):
        assert (correlation_of(np.cos(np.linspace(0, 4, count)), 0)[0] > 1) == correlated
    assert correlation_of(np.ones(1000), 0)[0] < 100, "a trend leaves some rows that count"


@pytest.mark.parametrize(("number", "is_plain"), [("5e29", True), ("2e30", False)])
def test_a_number_out_of_range_stands_for_none(number, is_plain):
    assert (plain_numbers(f"1,{number}\n2,3\n".encode(), ",", 2) is not None) == is_plain


@pytest.mark.parametrize(("size", "unit"), [(3.0, "m/s"), (9.0, "mm/s"), (3000.0, "mm/s"), (9000.0, "um/s")])
def test_a_unit_is_proposed_by_the_size_of_speeds(size, unit):
    column = HeaderColumn.read("slide", 1)
    assert _unit_of_speed(column, (), {0: np.array([0.1, size])}) == unit


def up_and_down(count, turn, gap=0.02):
    """Speeds that rise and fall between two ends, and coefficients with a hysteresis."""
    rise = np.linspace(1 - turn, 1, count)
    v = np.concatenate([np.linspace(0, 1, 40), *[rise[::-1], rise] * 3])
    sign = np.sign(np.gradient(v))
    mu = 0.3 - 0.1 * v + gap * sign + 1e-4 * np.random.default_rng(2).normal(size=len(v))
    return v, mu


def branches_of(v, mu):
    order = np.argsort(v, kind="stable")
    return sweep_branches_of(v[order], mu[order], np.ones(len(v)), order)


@pytest.mark.parametrize(("turn", "is_branch"), [(0.05, False), (0.2, True)])
def test_a_small_return_of_the_speed_is_jitter(turn, is_branch):
    assert (branches_of(*up_and_down(12, turn)) is not None) == is_branch


@pytest.mark.parametrize(("speeds", "is_branch"), [(2, False), (9, True)])
def test_a_branch_has_some_speeds(speeds, is_branch):
    v = np.concatenate([np.linspace(0, 1, speeds), np.linspace(1, 0, speeds)] * 8)
    mu = 0.3 - 0.1 * v
    assert (branches_of(v, mu) is not None) == is_branch


def test_a_dwell_at_a_turn_is_halved():
    """Rows that differ by a hundredth dwell at the turn; those that differ by 4 % are on their branch."""
    for step, dwells in ((0.01, True), (0.04, False)):
        rise = np.concatenate([np.linspace(0, 0.8, 9), [1 - step, 1.0]])
        v = np.concatenate([rise, [1 - step, 1 - step, 1 - step, 1 - step], np.linspace(0.8, 0, 9)])
        found = branches_of(np.tile(v, 4), np.tile(0.3 - 0.1 * v, 4))
        swept = found.sweep[np.argsort(np.argsort(np.tile(v, 4), kind="stable"))]
        assert (swept[: len(v)].tolist().count(1) > 11) == dwells


def test_speeds_held_at_one_value_turn_in_order():
    """Within 2 % of each other, any two are near enough for a dwell."""
    for seed in range(20):
        v = 1 + 0.02 * np.random.default_rng(seed).uniform(-1, 1, 30)
        turns = sweep_branches._turns(v)
        assert np.all(np.diff([0, *turns, len(v)]) > 0)
        assert branches_of(v, 0.3 - 0.1 * v) is None


@pytest.mark.parametrize(("swept", "is_sweep"), [(0.55, False), (0.95, True)])
def test_most_rows_are_on_branches_where_speeds_were_swept(swept, is_sweep):
    rng = np.random.default_rng(7)
    sweeps = np.tile(np.concatenate([np.linspace(0, 1, 30), np.linspace(1, 0, 30)]), 5)
    mixed = rng.uniform(0, 1, round(len(sweeps) * (1 / swept - 1)))
    assert bool(sweep_branches._sweeps(np.concatenate([sweeps, mixed]))[1]) == is_sweep


@pytest.mark.parametrize(("share", "is_said"), [(0.025, False), (0.1, True)])
def test_a_few_rows_of_one_branch_do_not_matter(share, is_said):
    v = np.linspace(0, 1, 200)
    sweep = np.where(np.arange(200) % 2, 1, -1)
    sweep[: round(200 * share)] = 1
    assert bool(sweep_branches._alone(v, sweep)) == is_said


@pytest.mark.parametrize(("count", "is_told"), [(6000, False), (20_000, True)])
def test_many_rows_are_told_by_some_thousands(count, is_told):
    """Fewer are looked at one by one."""
    v = np.random.default_rng(1).uniform(0, 1, count)
    assert sweep_branches._is_shuffled(v) == is_told


def test_a_smooth_curve_has_a_column_for_some_rows():
    columns = [sweep_branches.splines(np.linspace(0, 1, count)).shape[1] for count in (3, 60, 10_000)]
    assert columns[0] == 4, "a cubic"
    assert 3 < 60 / columns[1] < 12
    assert 15 < columns[2] < 60


def test_noise_that_is_normal_after_all_keeps_its_efficiency():
    """P. J. Huber 1964: 95 % of that of least squares."""
    k = heavy_tails._HUBER
    inside = 2 * ndtr(k) - 1
    square = inside - 2 * k * np.exp(-(k**2) / 2) / np.sqrt(2 * np.pi) + k**2 * (1 - inside)
    assert inside**2 / square == pytest.approx(0.95, abs=1e-3)


def averaged(values, weights, speeds):
    rows = [ByLaw(str(value), weight, value, 0.01) for value, weight in zip(values, weights, strict=True)]
    return Averaged.of(rows, {}, speeds=speeds, dof=3.0, unknown=0.0)


@pytest.mark.parametrize(("speeds", "below"), [(5, None), (8, True)])
def test_the_average_decides_where_laws_can_be_weighed(speeds, below):
    """A law of little weight would keep all laws from agreeing."""
    assert Decision.of_measured(1.5, 0.0, averaged((2.0, 1.0), (0.99, 0.01), speeds)).below is below


def test_friction_that_builds_up_unseen_is_rare_and_may_be():
    row = ByLaw("one", 1.0, 2.0, 0.01, unmeasured=1.9)
    above = Averaged.of([row], {}, speeds=9, dof=30.0, unknown=0.0).above(1.0)
    assert 0.97 < above < 0.995


@pytest.mark.parametrize(("size", "is_seen"), [(0.0, False), (0.02, True)])
def test_two_further_terms_are_looked_for(size, is_seen):
    """Of the third degree, beside a law of a line, whose quadratic part is not there."""
    rng = np.random.default_rng(4)
    x = np.linspace(-1, 1, len(V))
    residuals = 0.005 * rng.normal(size=len(V)) + size * (5 * x**3 - 3 * x) / 2
    derivatives = np.column_stack([np.ones_like(x), x])
    residuals -= derivatives @ np.linalg.lstsq(derivatives, residuals, rcond=None)[0]
    chance = chance_of_residuals(residuals, derivatives, polynomials_of_rank(V, 2), 1e-12)
    assert (chance < 0.001) == is_seen


def test_starts_differ_and_reach_beyond_what_was_measured():
    problem = Problem(ss.laws.gaussian, Measurements.of(V, LAW.mu(V)))
    scales = np.array([start[list(problem.names).index("v_s")] for start in problem.starts()])
    assert 2 < len(scales) < 9
    drawn = np.array([trial[list(problem.names).index("v_s")] for trial in problem._trials(())])
    assert 20 < len(drawn) < 90
    assert V[0] / 8 < drawn.min() < V[0] / 2
    assert 2 * V[-1] < drawn.max() < 8 * V[-1]
    assert np.min(np.abs(np.diff(np.log(np.sort(scales))))) > 0.5


# -- fits ------------------------------------------------------------------------------------------


def warnings_of(errors, correlation=0.0):
    """What is warned of where parameters have such relative errors, and one correlation."""
    problem = Problem(ss.laws.exponential, Measurements.of(V, LAW.mu(V)))
    p = np.array([float(LAW.values[name]) for name in problem.names])
    deviations = errors * p
    correlations = np.eye(len(p))
    correlations[0, 1] = correlations[1, 0] = correlation
    covariance = correlations * np.outer(deviations, deviations)
    return " ".join(fitting._warnings(problem, p, covariance, fitting._Noise(), 1e-4))


def test_parameters_that_are_hardly_determined_are_named():
    assert warnings_of(0.3) == ""
    assert "hardly determine it" in warnings_of(0.9)
    assert "hardly distinguished" not in warnings_of(0.1, 0.995)
    assert "hardly distinguished" in warnings_of(0.1, 0.9999)


@pytest.mark.parametrize(("lowest", "is_measured"), [(0.05, True), (0.12, False)])
def test_a_law_without_a_jump_is_measured_where_it_has_not_yet_risen(lowest, is_measured):
    """That of 0.1 m/s has three quarters of its friction at 0.097 m/s."""
    law = ss.FrictionLaw("0.4*tanh(v/0.1)")
    measured = Measurements.of([lowest, 1.8 * lowest, 0.5, 1], [0.1, 0.2, 0.4, 0.4])
    if is_measured:
        fitting._require_rise(law, measured)
    else:
        with pytest.raises(ss.InputError, match="its friction builds up below"):
            fitting._require_rise(law, measured)


class Binned(Exception):
    """Says into how many bins rows are put."""


@pytest.mark.parametrize(("count", "is_binned"), [(600, False), (2000, True)])
def test_many_rows_begin_as_some_hundred_means(count, is_binned, monkeypatch):
    def binned(measured, bins):
        raise Binned(bins)

    monkeypatch.setattr(Measurements, "binned", binned)
    v = np.linspace(0.05, 1, count)
    if is_binned:
        with pytest.raises(Binned) as stopped:
            ss.fit(v, LAW.mu(v), laws="linear")
        assert 150 < stopped.value.args[0] < 700
    else:
        assert ss.fit(v, LAW.mu(v), laws="linear").best.name == "linear"


def one_fit(count, *, chi_squared=1.0, inflation=1.0):
    values = dict.fromkeys("abcdef"[:count], 1.0)
    return SimpleNamespace(values=values, chi_squared=chi_squared, inflation=inflation)


def test_a_parameter_weighs_more_than_for_akaike_and_less_than_for_schwarz():
    weights = weighing.weigh(Measurements.of([0.1, 0.5], [0.3, 0.2]), [one_fit(2), one_fit(3)]).weights
    assert 1 < np.log(weights[0] / weights[1]) < np.log(100) / 2


@pytest.mark.parametrize(("variance", "inflation"), [(1.15, 1.0), (2.0, 5.0)])
def test_rows_count_by_the_laws_that_describe_them_about_as_well(variance, inflation):
    fits = [one_fit(2, chi_squared=20, inflation=5.0), one_fit(2, chi_squared=20 * variance)]
    assert weighing._inflation(22, fits) == inflation


@pytest.mark.parametrize(("lowest", "is_far"), [(0.03, False), (0.1, True)])
def test_friction_near_rest_hardly_matters(lowest, is_far):
    fit = SimpleNamespace(measured=Measurements.of([lowest, 1.5], [0.3, 0.2]))
    assert (Fit.extrapolation(fit, 0.5) is not None) == is_far


@pytest.mark.parametrize(("end", "is_found"), [(40, True), (120, False)])
def test_the_end_of_an_interval_is_sought_within_some_errors(end, is_found):
    fit = SimpleNamespace(
        values={"a": 0.0}, free_law=SimpleNamespace(parameters={"a": SimpleNamespace(positive=False)}),
        _rise=lambda _, value: (2 * value / end) ** 2,
    )  # fmt: skip
    for step in (1.0, -1.0):
        assert Fit._end(fit, "a", step, 2.0) == pytest.approx(step * (end if is_found else np.inf))


@pytest.mark.parametrize(("speeds", "few"), [(5, True), (12, False)])
def test_laws_are_ranked_by_some_speeds(speeds, few):
    assert Decision.of_measured(1.5, 0.0, averaged((2.0,), (1.0,), speeds)).few == few


# -- outliers --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("count", "noise", "off", "is_outlier"),
    [
        (60, 0.01, 0.04, False), (60, 0.01, 0.14, True),  # standard deviations
        (60, 0.0, 0.015, False), (60, 0.0, 0.06, True),  # what is told apart without noise
        (10, 0.0, 0.08, False), (10, 0.0, 0.3, True),  # few rows
    ],
)  # fmt: skip
def test_a_row_is_off_by_some_deviations(count, noise, off, is_outlier):
    rng = np.random.default_rng(5)
    y = 0.4 + noise * rng.normal(size=count)
    y[count // 2] = 0.4 + off
    assert _outliers(np.linspace(0.1, 1, count), y)[count // 2] == is_outlier


@pytest.mark.parametrize(("length", "is_read"), [(6000, True), (20_000, False)])
def test_a_line_is_no_file(tmp_path, length, is_read):
    path = write(tmp_path, "# " + "x" * length, "v [m/s],mu", "0.1,0.4", "0.2,0.35")
    if is_read:
        assert len(ss.read_measurements(path)) == 2
    else:
        with pytest.raises(ss.InputError, match="a row is a line of its own"):
            ss.read_measurements(path)


# -- coarse digits, heavy tails ----------------------------------------------------------------------


def test_noise_of_a_few_last_decimals_says_nothing_of_its_tails():
    """The median of normal noise of 1.5 decimals is 1 decimal, and half of its rows seem far off."""
    v = np.linspace(0.05, 1, 4000)
    rngs = [np.random.default_rng(seed) for seed in range(24)]
    coarse = [have_heavy_tails(v, (LAW.mu(v) + 1.5e-3 * rng.normal(size=len(v))).round(3)) for rng in rngs]
    fine = [have_heavy_tails(v, (LAW.mu(v) + 4e-3 * rng.standard_t(3.5, size=len(v))).round(3)) for rng in rngs]
    assert not any(coarse)
    assert sum(fine) > 20


def test_huber_weights_have_settled():
    """With them, the curve leaves residuals that ask for the same weights."""
    v = np.linspace(0.05, 1, 450)
    y = LAW.mu(v) + 0.004 * np.random.default_rng(3).standard_t(2.5, size=len(v))
    weights = heavy_tails.huber_weights(v, y)
    columns = sweep_branches.splines(v).toarray() * np.sqrt(weights)[:, None]
    factors = np.linalg.lstsq(columns, np.sqrt(weights) * y, rcond=None)[0]
    left = y - sweep_branches.splines(v) @ factors
    assert heavy_tails._weights_of(left) == pytest.approx(weights, abs=1e-5)


def test_huber_weights_are_settled_in_some_steps(monkeypatch):
    steps = []
    solve = np.linalg.lstsq
    monkeypatch.setattr(np.linalg, "lstsq", lambda *given, **how: steps.append(1) or solve(*given, **how))
    heavy_tails.huber_weights(V, LAW.mu(V) + 0.004 * np.random.default_rng(3).normal(size=len(V)))
    assert 10 <= len(steps) < 50


@pytest.mark.parametrize(("off", "is_outlier"), [(0.23, False), (0.7, True)])
def test_mu_may_rise_some_times_at_the_lowest_speed(off, is_outlier):
    """Above what follows, 0.1, by 2.3 or by 7 times that."""
    y = np.full(12, 0.1)
    y[0] += off
    assert _outliers(np.linspace(0.1, 1, 12), y)[0] == is_outlier


@pytest.mark.parametrize(
    ("speeds", "is_outlier"),
    [
        (np.geomspace(1, 128, 8), True),  # as far as such speeds are apart
        ([*range(1, 11), 18], False),  # four times as far as three before it, alone
        ([*range(10, 101, 10), 100.1, 100.2, 100.3, 115], True),  # no farther than others
        ([*range(10, 101, 10), 100.1, 100.2, 100.3, 150], False),
    ],
)  # fmt: skip
def test_a_row_far_from_others_is_no_outlier(speeds, is_outlier):
    y = np.full(len(speeds), 0.4)
    y[-1] = 0.9
    assert _outliers(np.asarray(speeds, dtype=float), y)[-1] == is_outlier


# -- branches ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gap", "differ"), [(3e-7, False), (3e-6, True)])
def test_branches_that_differ_by_a_millionth_are_alike(gap, differ):
    """Of the largest coefficient; without noise."""
    v = np.concatenate([np.linspace(0, 1, 40), np.linspace(1, 0, 40)])
    assert branches_of(v, np.ones(80) + gap / 2 * np.repeat([1, -1], 40)).differ == differ


def test_hysteresis_is_followed_as_a_polynomial_of_low_degree():
    v = np.concatenate([np.linspace(0, 1, 200), np.linspace(1, 0, 200)])
    gap = np.repeat([1, -1], 200) * 0.01 * np.tanh(6 * (v - 0.3))
    mu = 0.4 + gap + 1e-4 * np.random.default_rng(1).normal(size=400)
    assert 2 <= branches_of(v, mu).terms.shape[1] <= 5


@pytest.mark.parametrize(("lowest", "offset"), [(0.2, 0.02), (0.2, 0.0), (1.0, 0.0), (1.0, 0.02)])
def test_an_offset_is_told_where_directions_share_speeds(lowest, offset):
    """Beyond 0.3 m/s in one direction, and from there on in the other, any offset is a curve too."""
    v = np.concatenate([np.linspace(0.05, 0.3, 20), np.linspace(lowest, lowest + 1, 20)])
    direction = np.repeat([1, -1], 20)
    mu = LAW.mu(v) + offset * direction + 1e-3 * np.random.default_rng(2).normal(size=40)
    order = np.argsort(v)
    found = sweep_branches_of(v[order], mu[order], np.ones(40), order, direction[order])
    told = found.offset if found else 0.0
    assert told == pytest.approx(offset if lowest < 0.3 else 0.0, abs=2e-3)


# -- files -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("size", "why"), [(100_000_000, "workbook"), (400_000_000, "nothing that is read here is as long")]
)
def test_a_file_of_a_million_rows_is_read(tmp_path, size, why):
    """Of 100 characters each; no longer one is even looked into."""
    path = tmp_path / "rows.csv"
    with path.open("wb") as file:
        file.write(b"PK\x03\x04")
        file.truncate(size)
    with pytest.raises(ss.InputError, match=why):
        ss.read_measurements(path)


@pytest.mark.parametrize(("notes", "is_read"), [(250, True), (800, False)])
def test_the_header_is_among_the_first_lines(tmp_path, notes, is_read):
    path = write(tmp_path, *["# -"] * notes, "v [mm/s],mu", "100,0.4", "200,0.35")
    if is_read:
        assert ss.read_measurements(path).v.tolist() == [0.1, 0.2]
    else:
        with pytest.raises(ss.InputError, match="a table begins with a header"):
            ss.read_measurements(path)


def assert_left_out(path, count, refusal):
    """So many rows are read where others may be left out, or the file is refused."""
    if refusal is None:
        assert len(ss.read_measurements(path, leave_out=True)) == count
    else:
        with pytest.raises(ss.InputError, match=refusal):
            ss.read_measurements(path, leave_out=True)


@pytest.mark.parametrize(("wrong", "is_read"), [(6, True), (20, False)])
def test_a_few_rows_may_break_a_rule(tmp_path, wrong, is_read):
    """Of 50; where 40 % of the coefficients are above 5, their column is one of other units."""
    faulty = np.random.default_rng(2).choice(48, wrong, replace=False) + 1
    rows = [f"{0.02 * i + 0.02},{9 if i in faulty else 0.4}" for i in range(50)]
    path = write(tmp_path, "v [m/s],mu", *rows)
    assert_left_out(path, 50 - wrong, None if is_read else "too many to leave out")


@pytest.mark.parametrize(("wrong", "is_read"), [(2, True), (5, False)])
def test_a_few_rows_of_one_end_may_be_left_out(tmp_path, wrong, is_read):
    """In a file in no order."""
    order = np.random.default_rng(4).permutation(50)
    rows = [f"{0.02 * i + 0.02},{9 if i >= 50 - wrong else 0.4}" for i in order]
    path = write(tmp_path, "v [m/s],mu", *rows)
    assert_left_out(path, 50 - wrong, None if is_read else "they are those of the highest speeds")


# -- what rows determine -----------------------------------------------------------------------------


@pytest.mark.parametrize(("error", "is_fitted"), [(60, True), (200, False)])
def test_a_parameter_was_not_measured_where_its_error_is_some_hundred_times_as_large(error, is_fitted):
    """Rows of the law itself, with standard deviations in proportion to that error."""
    known = ss.fit(V, LAW.mu(V), np.full(len(V), 1e-3), laws="exponential").best
    sigma = np.full(len(V), 1e-3 * error * known.values["alpha"] / known.standard_errors["alpha"])
    if is_fitted:
        fit = ss.fit(V, LAW.mu(V), sigma, laws="exponential").best
        assert fit.standard_errors["alpha"] == pytest.approx(error * fit.values["alpha"])
    else:
        with pytest.raises(ss.InputError, match="these measurements say nothing of alpha"):
            ss.fit(V, LAW.mu(V), sigma, laws="exponential")


@pytest.mark.parametrize(("share", "named"), [(0.05, "p and q"), (0.3, "p and q and r")])
def test_parameters_with_a_small_part_in_what_has_no_effect_are_not_named(share, named):
    with pytest.raises(ss.InputError, match=f"do not tell {named} apart"):
        ss.fit(V, 1 - 0.2 * V, laws=f"p + q*(1 + {share}*v) + r*v")


@pytest.mark.parametrize(("share", "is_term"), [(0.1, False), (0.35, True)])
def test_a_term_is_what_the_law_explains_in_good_part_only(share, is_term):
    """Residuals that follow what a law leaves of a line, this share of it."""
    x = np.linspace(-1, 1, len(V))
    polynomials = np.linalg.qr(np.polynomial.legendre.legvander(x, 6))[0]
    wave = np.cos(25 * x)
    wave -= polynomials @ (polynomials.T @ wave)
    wave /= np.linalg.norm(wave)
    explained = np.sqrt(1 - share**2)
    derivatives = np.column_stack([polynomials[:, 0], explained * polynomials[:, 1] + share * wave])
    left = share * polynomials[:, 1] - explained * wave
    residuals = 0.005 * np.random.default_rng(1).normal(size=len(V)) + 0.05 * left
    residuals -= derivatives @ np.linalg.lstsq(derivatives, residuals, rcond=None)[0]
    chance = chance_of_residuals(residuals, derivatives, polynomials[:, 1:], 1e-12)
    assert (chance < 0.001) == is_term


# -- searches ----------------------------------------------------------------------------------------


def test_a_jump_is_looked_for_again_some_gaps_away():
    """The lesser of two jumps is a minimum too, 40 gaps from the greater one."""
    v = np.linspace(0.01, 1, 300)
    mu = 0.3 + 0.1 * (np.arange(300) >= 100) - 0.09 * (np.arange(300) >= 140)
    measured = Measurements.of(v, mu + 1e-4 * np.random.default_rng(1).normal(size=300))
    problem = Problem(ss.FrictionLaw("Piecewise((a, v < v_1), (b, True))"), measured)
    start = {"a": 0.33, "b": 0.31, "v_1": (v[139] + v[140]) / 2}
    found = problem.minimum(np.array([start[name] for name in problem.names]))
    assert v[99] < found.p[problem.names.index("v_1")] < v[100]
    assert len(problem.levels_near(problem.features[0], found.p)) < 200, "among many rows not at all of them"


def test_only_the_best_of_a_grid_are_solved():
    """Those beside each other, and the same waves half a turn on."""
    problem = Problem(ss.FrictionLaw("a + h*sin(w*v)"), Measurements.of(V, LAW.mu(V)))
    solved = []
    with_linear = problem._with_linear

    def counted(p):
        solved.append(p)
        return with_linear(p)

    problem._with_linear = counted
    (feature,) = problem.features
    problem._moved(np.ones(3), feature, feature.levels)
    assert 2 <= len(solved) < 6


def test_a_grid_is_computed_in_some_parts():
    """Of four million residuals; each part is some megabytes large."""
    measured = Measurements.of(np.linspace(0.05, 1.2, 1000), np.ones(1000))
    problem = Problem(ss.FrictionLaw("a + b*exp(-v/v_1)"), measured)
    calls = []
    value = problem._value

    def counted(*arguments):
        calls.append(np.broadcast(*arguments).size)
        return value(*arguments)

    problem._value = counted
    problem._misfits(np.ones((4000, 3)))
    assert sum(calls) == 4_000_000
    assert 4 < len(calls) < 20


def test_a_few_starts_differ():
    """Two scales leave room for many."""
    problem = Problem(ss.FrictionLaw("a + b*exp(-v/v_1) + d*exp(-v/v_2)"), Measurements.of(V, LAW.mu(V)))
    assert 2 < len(list(problem.starts())) < 9


def test_a_file_of_which_all_rows_are_left_out_is_refused(tmp_path):
    """Where a comma is the decimal sign and parts the columns too."""
    path = write(tmp_path, "v [m/s],mu", "0,100,0,4000", "0,200,0,3500", "0,300,0,3000")
    with pytest.raises(ss.InputError, match="no row that is a measurement: 3 of another number of columns"):
        ss.read_measurements(path, leave_out=True)
