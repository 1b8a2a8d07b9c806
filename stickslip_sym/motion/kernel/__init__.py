"""Slip, from where it begins to where it ends, whatever the law.

In units of the belt's speed V, of 1/omega and of V/omega: w = |V - x'|/V >= 0 is the slip speed, q the
displacement from the point P where every forward stick phase ends, and side = 1 where the mass is slower than
the belt, -1 where it is faster. With eta = N/(V sqrt(k m)) and zeta = c/(2 sqrt(k m)),

    q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.

So w = 0 is the belt's speed exactly, and P is the origin: no digits cancel where returns are decided. Backward in
time the equations are the same, with q, eta and zeta negated.

The law is a `Rise`: polynomials, in smooth segments between the kinks of mu. A step ends wherever
something happens: at an extremum of w, at a kink, at the belt's speed. So w is monotone in a step, and an extremum
is located before a crossing of w = 0: an orbit that grazes the belt's speed touches 0 and turns within a step, and
no change of sign is left to see. A state between two steps is one shorter step from the first.

At w = 0 static friction holds the mass where |c V + k x| <= mu_static N, from q = -hold = -2 eta mu_static to P.
Anywhere else the mass passes the belt's speed: side changes its sign, and w grows from 0 again.

Where mu jumps up, the rates on both sides may lead to the jump: the mass then slides at the slip speed of the
jump, w is constant and q a straight line, until one of the rates turns (Filippov's sliding mode).

With p any quantity on which the motion depends, the wedge D = f_q dw/dp - f_w dq/dp of the rates f = (q', w')
with the derivative of the state obeys one scalar equation, since div f does not depend on q:

    D' = (div f) D + (1 - side w) dw'/dp,    div f = -eta V mu'(V w) - 2 zeta.

At an extremum dw/dp = D/(1 - side w); at a level of w that p does not move, dq/dp = -D/w'. Where mu jumps at a
level b(p), D - (1 - side w) db/dp changes as w' does; and so does D where the mass passes the belt's speed.

Explicit steps are those of DOP853, a Runge-Kutta method of order 8; in a fast decay of w they are those of the
linearly implicit Euler method, extrapolated to order 8. A step that is to end at an extremum of w, or at a level,
is taken again with other lengths: it is as accurate as the integration, and there are no interpolants.

`slip_data` names what the functions take and return, `forces` has the rates, `steps` the methods, `events` the
ends of steps, and `follow` the loop.

Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.5 (DOP853); II, IV.9 (extrapolation).
"""
