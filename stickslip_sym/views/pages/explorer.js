/* The page's own part: inputs, criteria at the operating point, the threshold, the motion, and pictures. DATA is written
   before, and so are mu, the criteria and the slip. */
const PERIODS = 15, LAST = 3, STEPS = 400;  // of free vibration, those that are judged, and steps of each
const POINTS = 120, THRESHOLDS = 40;  // of a curve by a formula, and of one that follows slips
const PAUSE = 12;  // milliseconds of work between which the page answers
const STANDARD_ERRORS = 1.96;  // on either side, 95 % of a normal distribution
const LOOKS = {
  equilibrium: {colour: "#B34700", dash: [10, 4]}, least_squares: {colour: "#000000", dash: [2, 4]},
  harmonic: {colour: "#555555", dash: [10, 3, 2, 3]}, threshold: {colour: "#00558C", dash: []},
};
const RED = "#B3200D";
const state = {}, at = id => document.getElementById(id);

function values_of_parameters(point = state) {
  return Object.keys(DATA.parameters).map(name => name in point ? point[name] : DATA.parameters[name]);
}

/* -- criteria -- */

const functions = {}, criteria = ["equilibrium", ...Object.keys(DATA.criteria), ...Object.keys(DATA.tables)];
for (const name in DATA.criteria) functions[name] = new Function("return damping_" + name)();

function by_criterion(name, V, point = state) {
  if (name === "equilibrium") return -point.N*slope(V, values_of_parameters(point));
  if (name in functions) {
    return functions[name](...DATA.criteria[name].map(key => key === "V" ? V : key in point ? point[key] : DATA.parameters[key]));
  }
  const V_slider = DATA.sliders[0];
  return point.N*in_rows(DATA.tables[name], Math.log(V/V_slider.low)/Math.log(V_slider.high/V_slider.low));
}

/* By the cubic through four rows of a table at even steps, two on either side; NaN outside. */
function in_rows(rows, at) {
  if (!(at > -1e-9 && at < 1 + 1e-9)) return NaN;
  const place = at*(rows.length - 1), first = Math.max(0, Math.min(rows.length - 4, Math.floor(place) - 1)), u = place - first;
  const [a, b, c, d] = rows.slice(first, first + 4);
  return (-a*(u - 1)*(u - 2)*(u - 3) + d*u*(u - 1)*(u - 2))/6 + (b*u*(u - 2)*(u - 3) - c*u*(u - 1)*(u - 3))/2;
}

/* -- the threshold, and how uncertain it is -- */

/* What is known of the threshold at a point: {value, error}, or null; or, roughly, as a number or null. */
function threshold_at(point, follow = threshold) {
  const first = ["least_squares", "harmonic", "equilibrium"].filter(name => criteria.includes(name))
    .map(name => by_criterion(name, point.V, point)).find(Number.isFinite);
  return follow(point, values_of_parameters(point), first);
}

/* The standard error that the uncertain inputs give a quantity; null where it is not known at a shifted point. */
function standard_error(quantity) {
  const {names, matrix} = DATA.covariance, slopes = [];
  for (let i = 0; i < names.length; i++) {
    const step = Math.sqrt(matrix[i][i])/2;
    const [above, below] = [1, -1].map(sign => quantity({...state, [names[i]]: state[names[i]] + sign*step}));
    if (above === null || below === null || !Number.isFinite(above - below)) return null;
    slopes.push((above - below)/(2*step));
  }
  const variance = slopes.reduce((sum, a, i) => sum + slopes.reduce((row, b, j) => row + a*b*matrix[i][j], 0), 0);
  return Math.sqrt(Math.max(variance, 0));
}

/* -- the motion: Runge and Kutta's steps in slip, and stick while friction can hold the mass -- */

function motion() {
  const {V, N, m, k, c} = state, p = values_of_parameters(), period = 2*Math.PI*Math.sqrt(m/k), h = period/STEPS;
  const holds = N*mu_static(1e-9*V, p), held = x => Math.abs(k*x + c*V) <= holds;
  const force = (x, y, side) => (side*N*mu(Math.max(side*(V - y), 1e-12*V), p) - c*y - k*x)/m;
  const found = {t: [0], x: [0], y: [V], stuck: 0};
  let x = 0, y = V, stick = held(0), side = 1;
  if (!stick) side = k*x + c*V > 0 ? 1 : -1;
  for (let i = 1; i <= PERIODS*STEPS; i++) {
    if (stick) {
      x += V*h;
      if (!held(x)) { stick = false; side = k*x + c*V > 0 ? 1 : -1; }
    } else {
      const a1 = force(x, y, side), y2 = y + h/2*a1, a2 = force(x + h/2*y, y2, side), y3 = y + h/2*a2;
      const a3 = force(x + h/2*y2, y3, side), y4 = y + h*a3, a4 = force(x + h*y3, y4, side);
      const before = y;
      x += h/6*(y + 2*y2 + 2*y3 + y4);
      y += h/6*(a1 + 2*a2 + 2*a3 + a4);
      if (side*(V - y) <= 0 && !(side*(V - before) === 0 && side*a1 < 0)) {
        y = V;
        stick = held(x);
        if (!stick) side = k*x + c*V > 0 ? 1 : -1;
      }
    }
    if (!Number.isFinite(x) || Math.abs(y) > 1e3*V) break;
    if (stick && i > (PERIODS - LAST)*STEPS) found.stuck++;
    found.t.push(i*h); found.x.push(x); found.y.push(y);
  }
  return found;
}

/* -- pictures -- */

function ticks(low, high) {
  const raw = (high - low)/5, size = 10**Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find(s => s*size >= raw)*size;
  const list = [];
  for (let i = Math.ceil(low/step); i*step <= high; i++) list.push(i*step);
  return list;
}

function draw(id, curves, labels, marks = []) {
  const canvas = at(id), g = canvas.getContext("2d"), left = 76, bottom = canvas.height - 48, right = canvas.width - 14, top = 14;
  const finite = [...curves, ...marks].flatMap(one => one.x.map((x, i) => [x, one.y[i]])).filter(one => one.every(Number.isFinite));
  g.clearRect(0, 0, canvas.width, canvas.height);
  if (!finite.length) return;
  const range = i => {
    const all = finite.map(one => one[i]), low = all.reduce((a, b) => Math.min(a, b)), high = all.reduce((a, b) => Math.max(a, b));
    const more = 0.05*(high - low) || 0.1*Math.abs(high) || 1;
    return [low - more, high + more];
  };
  const [x0, x1] = range(0), [y0, y1] = range(1);
  const px = x => left + (x - x0)/(x1 - x0)*(right - left), py = y => bottom - (y - y0)/(y1 - y0)*(bottom - top);
  g.font = "15px serif"; g.fillStyle = "#333"; g.strokeStyle = "#e3e3e3"; g.lineWidth = 1; g.textAlign = "center";
  for (const x of ticks(x0, x1)) { g.beginPath(); g.moveTo(px(x), top); g.lineTo(px(x), bottom); g.stroke(); g.fillText(+x.toPrecision(4), px(x), bottom + 18); }
  g.textAlign = "right";
  for (const y of ticks(y0, y1)) { g.beginPath(); g.moveTo(left, py(y)); g.lineTo(right, py(y)); g.stroke(); g.fillText(+y.toPrecision(4), left - 6, py(y) + 5); }
  g.textAlign = "center"; g.fillText(labels[0], (left + right)/2, canvas.height - 8);
  g.save(); g.translate(14, (top + bottom)/2); g.rotate(-Math.PI/2); g.fillText(labels[1], 0, 0); g.restore();
  for (const {x, y, colour, dash} of curves) {
    g.strokeStyle = colour; g.lineWidth = 1.8; g.setLineDash(dash || []); g.beginPath();
    let pen = false;
    x.forEach((one, i) => {
      if (!Number.isFinite(y[i])) { pen = false; return; }
      g[pen ? "lineTo" : "moveTo"](px(one), py(y[i])); pen = true;
    });
    g.stroke();
  }
  g.setLineDash([]);
  for (const {x, y, colour, size} of marks) {
    g.fillStyle = colour;
    x.forEach((one, i) => { g.beginPath(); g.arc(px(one), py(y[i]), size || 5, 0, 7); g.fill(); });
  }
}

function shown(value) {
  return Number.isFinite(value) ? String(+value.toPrecision(6)) : "not known";
}

/* A value with its standard error, to two digits of that. */
function with_error(value, error) {
  if (!(error > 0)) return shown(value);
  const decimals = Math.max(0, Math.min(12, 1 - Math.floor(Math.log10(error))));
  return `${value.toFixed(decimals)} ± ${error.toFixed(decimals)}`;
}

/* -- what the page shows -- */

/* A piece of a line as the picture has it. */
function swatch_of({colour, dash}) {
  const swatch = document.createElement("span"), looks = `stroke="${colour}" stroke-width="2.5" stroke-dasharray="${dash.join(" ")}"`;
  swatch.innerHTML = `<svg class="swatch" aria-hidden="true"><line x1="0" x2="34" y1="5" y2="5" ${looks}/></svg>`;
  return swatch;
}

const row_of = {};
for (const name of [...criteria, "threshold"]) {
  const row = document.createElement("tr"), label = document.createElement("th"), cell = document.createElement("td");
  const data = document.createElement("data"), swatch = swatch_of(LOOKS[name]);
  label.scope = "row";
  label.append(swatch, name === "threshold" ? "threshold, by following the slip" : name.replace("_", " "));
  data.id = "c-" + name;
  cell.append(data);
  row.append(label, cell);
  at("thresholds").append(row);
  row_of[name] = data;
}

function write_value(name, value, text) {
  row_of[name].value = value;
  row_of[name].textContent = text;
}

let curve = [];  // thresholds over the belt speed, as far as they have been computed
let generation = 0;  // of the inputs other than c

/* One step of slow work after another, as long as the inputs are the same. */
function in_steps(steps, of) {
  const started = performance.now();
  while (steps.length && performance.now() - started < PAUSE) steps.shift()();
  if (of !== generation) return;
  if (steps.length) setTimeout(() => in_steps(steps, of), 0);
}

function speeds(count) {
  return Array.from({length: count}, (_, i) => 2*state.V*(i + 1)/count);
}

let known = null, spread = null;  // the threshold here, and its standard error

/* Compute anew what does not depend on c: the threshold at once, its error and the curve in steps. */
function recompute() {
  generation++;
  known = threshold_at(state);
  spread = null;
  curve = [];
  const steps = speeds(THRESHOLDS).map(V => () => {
    const there = threshold_at({...state, V}, rough_threshold);
    curve.push({V, c: there === null ? NaN : there});
    if (curve.length % 8 === 0 || curve.length === THRESHOLDS) draw_plane();
  });
  if (DATA.covariance.names.length && known !== null) {
    steps.unshift(() => {
      spread = standard_error(point => threshold_at(point, rough_threshold));
      show_threshold();
    });
  }
  setTimeout(() => in_steps(steps, generation), 0);
}

function show_threshold() {
  if (known === null) write_value("threshold", "NaN", "not known: this page could not follow the slip to its end here");
  else write_value("threshold", known.value, `${with_error(known.value, spread)}`);
}

function draw_plane() {
  const over = speeds(POINTS), names = criteria;
  const curves = names.map(name => ({x: over, y: over.map(V => by_criterion(name, V)), ...LOOKS[name]}));
  const exact = {x: curve.map(one => one.V), y: curve.map(one => one.c), ...LOOKS.threshold};
  draw("plane", [...curves, exact].filter(one => one.y.some(Number.isFinite)), ["belt speed V (m/s)", "damping c (kg/s)"],
    [{x: [state.V], y: [state.c], colour: RED}]);
}

function draw_friction() {
  const p = values_of_parameters(), over = speeds(POINTS), slip = over.map(v => mu(v, p));
  const curves = [{x: over, y: slip, ...LOOKS.threshold}];
  if (DATA.covariance.names.some(name => name in DATA.parameters)) {
    const half = over.map(v => STANDARD_ERRORS*standard_error(point => mu(v, values_of_parameters(point))));
    for (const sign of [-1, 1]) {
      curves.push({x: over, y: slip.map((value, i) => value + sign*half[i]), colour: LOOKS.harmonic.colour, dash: [4, 4]});
    }
  }
  const [v, measured] = DATA.measured, seen = v.map((_, i) => i).filter(i => v[i] <= 2*state.V);
  const points = {x: seen.map(i => v[i]), y: seen.map(i => measured[i]), colour: "#777777", size: 2.5};
  draw("friction", curves, ["slip speed v (m/s)", "coefficient of friction"],
    [points, {x: [state.V], y: [mu(state.V, p)], colour: RED}]);
}

function update() {
  const wrong = sliders.filter(one => one.problem);
  if (wrong.length) {
    at("headline").className = "state";
    at("headline").textContent = wrong.map(one => one.problem).join(" ");
    return;
  }
  for (const name of criteria) {
    const value = by_criterion(name, state.V);
    write_value(name, value, shown(value));
  }
  show_threshold();
  const moved = motion(), sticks = moved.stuck > 0, headline = at("headline");
  headline.className = "state " + (sticks ? "sticks" : "slips");
  const side = known === null ? "The threshold is not known here." : Math.abs(state.c - known.value) <= known.error
    ? `The damping c = ${shown(state.c)} kg/s is at the threshold.`
    : `The damping c = ${shown(state.c)} kg/s is ${state.c < known.value ? "below" : "above"} the threshold, ${shown(known.value)} kg/s.`;
  headline.textContent = `${side} From x = 0 with the belt's speed the mass ` +
    (sticks ? `still sticks and slips after ${PERIODS - LAST} periods.` : `does not stick in the last ${LAST} of ${PERIODS} periods.`);
  draw_plane();
  draw_friction();
  draw("phase", [{x: moved.x, y: moved.y, ...LOOKS.threshold}], ["displacement x (m)", "velocity (m/s)"]);
  draw("time", [{x: moved.t, y: moved.y, ...LOOKS.threshold}], ["time t (s)", "velocity (m/s)"]);
}

/* -- inputs: a slider and a field for each quantity -- */

/* A number as people write it, with a point or a comma; NaN for anything else. */
function number_of(text) {
  const plain = text.trim().replace("−", "-").replace(",", ".");
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}

/* Why a value cannot be had, or nothing. */
function problem_of(one, value) {
  if (!Number.isFinite(value)) return `${one.name} is not a number.`;
  if (one.sign === "positive" && !(value > 0)) return `${one.name} must be positive: it is the ${one.meaning}.`;
  if (one.sign === "nonnegative" && value < 0) return `${one.name} must not be negative.`;
  if (value > one.most) return `${one.name} can be at most ${shown(one.most)}: the law was measured up to twice that.`;
  return "";
}

const highest = Math.max(1e-9, DATA.c, ...criteria.map(name => {
  for (const one of DATA.sliders) state[one.name] = one.value;
  return 3*Math.abs(by_criterion(name, state.V));
}).filter(Number.isFinite));
const sliders = [
  {name: "c", value: DATA.c, low: Math.min(0, 2*DATA.c), high: highest, unit: "kg/s", meaning: "damping", sign: "", linear: true},
  ...DATA.sliders,
];

for (const one of sliders) {
  const row = document.createElement("div"), bar = document.createElement("input"), box = document.createElement("input");
  const linear = one.linear || one.low <= 0, name = document.createElement("label");
  const to_value = s => linear ? one.low + s*(one.high - one.low) : one.low*(one.high/one.low)**s;
  const to_share = value => linear ? (value - one.low)/(one.high - one.low) : Math.log(value/one.low)/Math.log(one.high/one.low);
  const unit = one.unit ? ` (${one.unit})` : "", described = (one.meaning || one.name) + (one.unit ? ` in ${one.unit}` : "");
  name.textContent = one.name + unit; name.title = one.meaning; row.className = "slider"; name.htmlFor = "value-" + one.name;
  Object.assign(bar, {type: "range", min: 0, max: 1, step: 0.001, id: "slider-" + one.name});
  Object.assign(box, {type: "text", inputMode: "decimal", autocomplete: "off", id: "value-" + one.name});
  bar.setAttribute("aria-label", `${one.name}, ${described}`);
  box.setAttribute("aria-label", `${one.name}, ${described}`);
  const accept = value => {
    one.problem = problem_of(one, value);
    box.setAttribute("aria-invalid", one.problem ? "true" : "false");
    if (one.problem) return;
    state[one.name] = value;
    bar.value = to_share(value);
    bar.setAttribute("aria-valuetext", `${+value.toPrecision(6)}${one.unit ? " " + one.unit : ""}`);
  };
  one.set = value => { box.value = +value.toPrecision(8); accept(value); };
  const changed = () => { if (one.name !== "c" && !sliders.some(other => other.problem)) recompute(); update(); };
  bar.addEventListener("input", () => { one.set(to_value(+bar.value)); changed(); });
  box.addEventListener("input", () => { accept(number_of(box.value)); changed(); });
  row.append(name, bar, box);
  at("sliders").append(row);
  one.set(one.value);
}
at("reset").addEventListener("click", () => { sliders.forEach(one => one.set(one.value)); recompute(); update(); });
recompute();
update();
