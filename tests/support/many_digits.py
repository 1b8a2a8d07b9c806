"""A slip phase with 20 digits, by a method that no engine of the package uses."""

import mpmath


def exact_return(law, osc):
    """Return tau and q of the return of the slip from P with 20 digits, by extrapolated midpoint steps.

    E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, section II.9.
    """
    mu = law.function("mpmath")
    eta, zeta, static = (mpmath.mpf(value) for value in (osc.eta, osc.zeta, law.static_value))

    def rates(state):
        q, w = state
        if w < -1:
            raise OverflowError("a step too long")
        return 1 - w, eta * (static - mu(osc.V * w)) + q - 2 * zeta * w

    def add(state, factor, other):
        return [a + factor * b for a, b in zip(state, other, strict=True)]

    def step(state, length):
        rows, first = [], rates(state)
        for k in range(1, 10):
            h = length / (2 * k)
            old, new = state, add(state, h, first)
            for _ in range(2 * k - 1):
                old, new = new, add(old, 2 * h, rates(new))
            row = [[(a + b) / 2 for a, b in zip(new, add(old, h, rates(new)), strict=True)]]
            for j in range(1, k):
                gain = mpmath.mpf(k * k) / (k - j) ** 2 - 1
                row.append(add(row[-1], 1 / gain, add(row[-1], -1, rows[-1][j - 1])))
            rows.append(row)
        (*_, before, last) = rows[-1]
        return last, max(abs(a - b) for a, b in zip(before, last, strict=True))

    tau, state, length = mpmath.mpf(0), [mpmath.mpf(0), mpmath.mpf(0)], mpmath.mpf("0.01")
    while True:
        try:
            after, error = step(state, length)
        except OverflowError:
            error = 1
        if error > 1e-17:
            length *= 0.6
        elif after[1] < 0 < tau:
            break
        else:
            tau, state = tau + length, after
            length *= 1.3 if error < 1e-19 else 1
    time = length * state[1] / (state[1] - after[1])
    for _ in range(8):
        end = step(state, time)[0]
        time -= end[1] / rates(end)[1]
    return tau + time, step(state, time)[0][0]
