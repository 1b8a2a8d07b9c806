/* The threshold of damping, by following the slip that begins where a forward stick phase ends, the point P.

   In units, with the slip speed V w, the displacement q from P over V/omega and the time over 1/omega:
   q' = 1 - w and w' = eta (mu_static - mu(V w)) + q - 2 zeta w, from w = q = 0. The slip returns to the belt's speed,
   w = 0, below the threshold; above it w has a minimum above 0. The function `fate` is negative in the first case,
   positive in the second, and null where neither has been seen: what is not known is no answer. */

const MOST_STEPS = 40000;  // of one slip; more means that it creeps or is stiff: not known
const LONGEST_STEP = 0.1;  // a sixtieth of a free vibration
const WIDEST = 1/16;  // of 1 + w that w changes in a step
const KINK = 1e-8, SMOOTH_KINK = 1e-2;  // of V: widths over which a step may pass a kink, and one where both slopes meet
const GRID = 1500, REACH = 1e-9;  // slip speeds at which arguments are looked at, and the lowest of them over V
const ROUGH = 1e-9;  // error of a step where a curve is drawn
const COARSE = 1e-10, FINE = 1e-12;  // errors of a step; the difference of their thresholds is the stated error
const ACCEPTED = 1e-6;  // relative error above which a threshold is not known

/* Nodes and weights of the pair of Dormand and Prince, of orders 5 and 4. */
const STAGES = [
  [1/5], [3/40, 9/40], [44/45, -56/15, 32/9], [19372/6561, -25360/2187, 64448/6561, -212/729],
  [9017/3168, -355/33, 46732/5247, 49/176, -5103/18656], [35/384, 0, 500/1113, 125/192, -2187/6784, 11/84],
];
const DIFFERENCE = [71/57600, 0, -71/16695, 71/1920, -17253/339200, 22/525, -1/40];

/* Where mu varies quickly up to a slip speed: places, and widths that a step may have there. */
function quick_places(p, V, highest) {
  const places = kinks(p).filter(place => place > 0 && place < highest).map(speed => ({speed, width: (SLOPES_MEET ? SMOOTH_KINK : KINK)*V}));
  const ratio = Math.log(highest/(REACH*V))/GRID;
  const speeds = Array.from({length: GRID + 1}, (_, i) => REACH*V*Math.exp(i*ratio));
  const even = Array.from({length: GRID}, (_, i) => (i + 1)/GRID*highest);
  const all = [...speeds, ...even].sort((a, b) => a - b);
  inner_functions.forEach(({value, slope, is_base}) => {
    for (const sought of [value, slope]) {
      let before = sought(all[0], p);
      for (let i = 1; i < all.length; i++) {
        const after = sought(all[i], p);
        if (before*after < 0) {
          const speed = zero_between(v => sought(v, p), all[i - 1], all[i]);
          places.push({speed, width: Math.max(width_at(speed, value, slope, is_base, p), KINK*V)});
        }
        before = after;
      }
    }
  });
  return places;
}

/* The change of v over which an argument changes by 1, or a base by itself. */
function width_at(v, value, slope, is_base, p) {
  const nearby = 1e-5*v, first = Math.abs(slope(v, p));
  const second = Math.abs(slope(v + nearby, p) - slope(v - nearby, p))/(4*nearby);
  const size = is_base ? Math.abs(value(v, p)) : 1;
  return 1/Math.max(first/size, Math.sqrt(second/size));
}

function zero_between(f, low, high) {
  const rises = f(high) > 0;
  for (let i = 0; i < 80; i++) {
    const middle = (low + high)/2;
    if (middle <= low || middle >= high) break;
    if ((f(middle) > 0) === rises) high = middle; else low = middle;
  }
  return (low + high)/2;
}

/* A law at values of its parameters and a belt speed, as the slip needs it. */
function law_at(point, p) {
  const {V, N, m, k} = point, impedance = Math.sqrt(k)*Math.sqrt(m), eta = N/V/impedance;
  const least = 1e-12*V, onset = mu(least, p), holds = mu_static(least, p);
  const friction = w => mu(Math.max(V*w, least), p);
  const highest = V*(4 + 4*eta*Math.max(Math.abs(holds), Math.abs(friction(1)), Math.abs(friction(3))));
  const jump = eta*(holds - onset), decay = eta*V*slope(V, p), places = quick_places(p, V, highest);
  return {V, eta, impedance, friction, holds, jump, decay, places};
}

/* Negative if the slip returns: minus half the square of its w' there. Positive if it does not: its least w. */
function fate(law, zeta, tolerance) {
  const rate = (w, q) => law.eta*(law.holds - law.friction(w)) + q - 2*zeta*w;
  const step = (w, q, h) => {
    const dw = [rate(w, q)], dq = [1 - w];
    let at = w, across = q;
    for (const row of STAGES) {
      at = w; across = q;
      row.forEach((weight, i) => { at += h*weight*dw[i]; across += h*weight*dq[i]; });
      dw.push(rate(at, across)); dq.push(1 - at);
    }
    const off = slopes => h*DIFFERENCE.reduce((sum, weight, i) => sum + weight*slopes[i], 0);
    return {w: at, q: across, error: Math.max(Math.abs(off(dw)), Math.abs(off(dq)))};
  };
  const allowed = (before, after) => law.places.every(({speed, width}) => {
    const distance = Math.abs(before - speed);
    return Math.abs(after - before) <= Math.max(width, distance/2);
  });
  let w = 0, q = 0, h = 1e-3*Math.min(1, 1/(1 + Math.abs(zeta) + law.eta)), falling = false;
  for (let i = 0; i < MOST_STEPS; i++) {
    const next = step(w, q, h);
    const small = Math.abs(next.w - w) <= WIDEST*(1 + Math.abs(w)) && allowed(law.V*w, law.V*next.w);
    if (!(next.error <= tolerance) || !small) {
      h *= small && Number.isFinite(next.error) ? Math.max(0.2, 0.9*(tolerance/next.error)**0.2) : 0.5;
      if (!(h > 1e-14)) return null;
      continue;
    }
    const slope = rate(next.w, next.q), turns = falling && slope >= 0;
    const turn = turns ? zero_between(length => { const end = step(w, q, length); return rate(end.w, end.q); }, 0, h) : h;
    const lowest = turns ? step(w, q, turn) : next;
    if (lowest.w <= 0 && w > 0) {
      const end = step(w, q, zero_between(length => step(w, q, length).w, 0, turn));
      return -0.5*(law.jump + end.q)**2;
    }
    if (turns && lowest.w < 1) return lowest.w;
    // Beside rest that small motions come back to, the slip has ended; from one that they leave, nothing is known yet.
    if (i > 100 && Math.abs(next.w - 1) < tolerance && Math.abs(slope) < tolerance) return law.decay + 2*zeta > 0 ? 1 : null;
    falling = slope < 0;
    ({w, q} = next);
    h = Math.min(LONGEST_STEP, h*Math.min(3, 0.9*(tolerance/Math.max(next.error, 1e-300))**0.2));
  }
  return null;
}

/* The damping in kg/s at which the fate changes, or null. */
function damping_between_fates(law, first, tolerance, digits) {
  const of = c => fate(law, c/(2*law.impedance), tolerance);
  let low = first, high = first, of_low = of(first), of_high = of_low;
  let width = Math.max(0.02*Math.abs(first), 1e-6*law.impedance*Math.min(1, law.eta));
  for (let i = 0; i < 60 && of_low !== null && of_high !== null && of_low*of_high > 0; i++, width *= 3) {
    if (of_low > 0) [high, of_high, low, of_low] = [low, of_low, low - width, of(low - width)];
    else [low, of_low, high, of_high] = [high, of_high, high + width, of(high + width)];
  }
  if (of_low === null || of_high === null || !(of_low <= 0 && of_high > 0)) return null;
  // Regula falsi by Illinois: the value at an end that stays is halved. Every third step halves the bracket.
  let [a, b, moved] = [of_low, of_high, 0];
  for (let i = 0; i < 200 && high - low > digits*Math.max(Math.abs(low), Math.abs(high)); i++) {
    let middle = i % 3 === 2 ? (low + high)/2 : (low*b - high*a)/(b - a);
    if (!(middle > low && middle < high)) middle = (low + high)/2;
    if (middle <= low || middle >= high) break;
    const value = of(middle);
    if (value === null) return null;
    if (value > 0) {
      [high, b] = [middle, value];
      if (moved > 0) a /= 2;
      moved = 1;
    } else {
      [low, a] = [middle, value];
      if (moved < 0) b /= 2;
      moved = -1;
    }
    if (value === 0) return middle;
  }
  return (low + high)/2;
}

/* The threshold as a curve shows it, or null. */
function rough_threshold(point, p, first) {
  return damping_between_fates(law_at(point, p), Number.isFinite(first) ? first : 0, ROUGH, 1e-9);
}

/* The threshold with its error: {value, error}, or null where the page does not know it. */
function threshold(point, p, first) {
  const law = law_at(point, p), from = Number.isFinite(first) ? first : 0;
  const rough = damping_between_fates(law, from, COARSE, 1e-9);
  if (rough === null) return null;
  const value = damping_between_fates(law, rough, FINE, 1e-10);
  if (value === null) return null;
  const error = Math.abs(value - rough) + 1e-9*Math.abs(value);
  const size = Math.abs(value) + 1e-2*law.eta*law.impedance*Math.abs(law.holds);
  return error <= ACCEPTED*size ? {value, error} : null;
}
