/* The page's own part: sliders, criteria at the operating point, the motion, and pictures. DATA is written before. */
const PERIODS = 15, LAST = 3, STEPS = 400;  // of free vibration, those that are judged, and steps of each
const POINTS = 120;  // of a curve
const COLOURS = {equilibrium: "#D55E00", least_squares: "#000", harmonic: "#777", exact: "#0072B2"};
const state = {c: DATA.c}, at = id => document.getElementById(id);

function values_of_parameters() {
  return Object.keys(DATA.parameters).map(name => name in state ? state[name] : DATA.parameters[name]);
}

/* -- criteria and exact thresholds -- */

const functions = {}, criteria = ["equilibrium", ...Object.keys(DATA.criteria), ...Object.keys(DATA.tables)];
for (const name in DATA.criteria) functions[name] = new Function("return damping_" + name)();

function by_criterion(name, V) {
  if (name === "equilibrium") return -state.N*slope(V, values_of_parameters());
  if (name in functions) return functions[name](...DATA.criteria[name].map(key => key === "V" ? V : state[key]));
  return state.N*in_rows(DATA.tables[name], share(DATA.sliders[0], V));
}

/* Where a value is on a logarithmic slider, 0 at its lower end and 1 at its upper one. */
function share(slider, value) {
  return Math.log(value/slider.low)/Math.log(slider.high/slider.low);
}

/* By the cubic through four rows of a table at even steps, two on either side; NaN outside. */
function in_rows(rows, at) {
  if (!(at > -1e-9 && at < 1 + 1e-9)) return NaN;
  const place = at*(rows.length - 1), first = Math.max(0, Math.min(rows.length - 4, Math.floor(place) - 1)), u = place - first;
  const [a, b, c, d] = rows.slice(first, first + 4);
  return (-a*(u - 1)*(u - 2)*(u - 3) + d*u*(u - 1)*(u - 2))/6 + (b*u*(u - 2)*(u - 3) - c*u*(u - 1)*(u - 3))/2;
}

function chebyshev(coefficients, x) {
  let b1 = 0, b2 = 0;
  for (let k = coefficients.length - 1; k > 0; k--) [b1, b2] = [2*x*b1 - b2 + coefficients[k], b1];
  return x*b1 - b2 + coefficients[0];
}

/* NaN beyond the table, and where a parameter, m or k is not the law's own. */
function exact(V) {
  const own = DATA.sliders.every(one => "VN".includes(one.name) || state[one.name] === one.value);
  if (DATA.exact === null || !own) return NaN;
  const [x, y] = [V, state.N].map((value, i) => 2*share(DATA.sliders[i], value) - 1);
  if (Math.max(Math.abs(x), Math.abs(y)) > 1 + 1e-9) return NaN;
  return state.N*chebyshev(DATA.exact.coefficients.map(row => chebyshev(row, y)), x);
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
  const canvas = at(id), g = canvas.getContext("2d"), left = 70, bottom = canvas.height - 48, right = canvas.width - 14, top = 14;
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
  for (const {x, y, colour} of marks) { g.fillStyle = colour; g.beginPath(); g.arc(px(x[0]), py(y[0]), 5, 0, 7); g.fill(); }
  curves.filter(one => one.name).forEach((one, i) => {
    g.textAlign = "right"; g.fillStyle = one.colour; g.fillText(one.name.replace("_", " "), right - 6, top + 18 + 18*i);
  });
}

function shown(value) {
  return Number.isFinite(value) ? value.toPrecision(6) : "none";
}

function update() {
  const speeds = Array.from({length: POINTS}, (_, i) => 2*state.V*(i + 1)/POINTS), names = [...criteria, "exact"];
  const answer = {};
  at("thresholds").replaceChildren(...names.map(name => {
    const row = document.createElement("tr"), value = name === "exact" ? exact(state.V) : by_criterion(name, state.V);
    const cells = [document.createElement("td"), document.createElement("td")], data = document.createElement("data");
    answer[name] = value;
    data.id = "c-" + name; data.value = value; data.textContent = shown(value);
    cells[0].textContent = name.replace("_", " "); cells[0].style.color = COLOURS[name] || "#000"; cells[1].append(data);
    row.append(...cells);
    return row;
  }));
  const moved = motion(), p = values_of_parameters(), slip = speeds.map(v => mu(v, p));
  const best = ["exact", "least_squares", names[0]].find(name => Number.isFinite(answer[name])), headline = at("headline");
  const by = best === "exact" ? "the exact threshold" : `the threshold by ${(best || names[0]).replace("_", " ")}`;
  headline.className = "state " + (moved.stuck > 0 ? "sticks" : "slips");
  headline.textContent = `After ${PERIODS - LAST} periods the motion from x = 0 ${moved.stuck > 0 ? "sticks and slips" : "slips only"}: ` +
    `c = ${shown(state.c)} kg/s, and ${by} is ${shown(answer[best])} kg/s.`;
  const curves = names.map(name => ({
    x: speeds, y: speeds.map(V => name === "exact" ? exact(V) : by_criterion(name, V)), colour: COLOURS[name] || "#000",
    dash: name === "exact" ? [] : [6, 4], name,
  })).filter(one => one.y.some(Number.isFinite));
  draw("plane", curves, ["belt speed V (m/s)", "damping c (kg/s)"], [{x: [state.V], y: [state.c], colour: "#CC3311"}]);
  draw("friction", [{x: speeds, y: slip, colour: COLOURS.exact}], ["slip speed v (m/s)", "coefficient of friction"], [{x: [state.V], y: [mu(state.V, p)], colour: "#CC3311"}]);
  draw("phase", [{x: moved.x, y: moved.y, colour: COLOURS.exact}], ["displacement x (m)", "velocity (m/s)"]);
  draw("time", [{x: moved.t, y: moved.y, colour: COLOURS.exact}], ["time t (s)", "velocity (m/s)"]);
}

/* -- sliders -- */

const highest = Math.max(DATA.c, 0, ...criteria.map(name => {
  for (const one of DATA.sliders) state[one.name] = one.value;
  return 3*by_criterion(name, state.V);
}).filter(Number.isFinite)) || 1;
const sliders = [{name: "c", value: DATA.c, low: 0, high: highest, unit: "kg/s", meaning: "damping", linear: true}, ...DATA.sliders];

for (const one of sliders) {
  const row = document.createElement("label"), bar = document.createElement("input"), box = document.createElement("input");
  const linear = one.linear || one.low <= 0, name = document.createElement("span");
  const to_value = s => linear ? one.low + s*(one.high - one.low) : one.low*(one.high/one.low)**s;
  const to_share = value => linear ? (value - one.low)/(one.high - one.low) : Math.log(value/one.low)/Math.log(one.high/one.low);
  name.textContent = one.name + (one.unit ? ` (${one.unit})` : ""); row.title = one.meaning; row.className = "slider";
  Object.assign(bar, {type: "range", min: 0, max: 1, step: 0.001, id: "slider-" + one.name});
  Object.assign(box, {type: "number", step: "any", id: "value-" + one.name});
  one.set = value => { state[one.name] = value; bar.value = to_share(value); box.value = +value.toPrecision(15); };
  bar.addEventListener("input", () => { const value = to_value(+bar.value); state[one.name] = value; box.value = +value.toPrecision(15); update(); });
  box.addEventListener("input", () => { if (Number.isFinite(box.valueAsNumber)) { state[one.name] = box.valueAsNumber; bar.value = to_share(state[one.name]); update(); } });
  row.append(name, bar, box);
  at("sliders").append(row);
  one.set(one.value);
}
at("reset").addEventListener("click", () => { sliders.forEach(one => one.set(one.value)); update(); });
update();
