"""A deflection in time: a spring with or without play behind a motor, links that rub."""

from typing import no_type_check

import numpy as np

from oed.dynamics.kernel import kernel

MOST_STEPS = 40  # of the equation of a step in time: each halves its bracket at least
ROUNDING = 1e-6  # of a bend: closer ones are one
EXACT = 1e-3  # of the sign's width: speeds closer than this are one


@kernel
@no_type_check  # compiled: the tests' type checker must not wrap it
def deflect(t, load, inertia, gear, brake):
    """Solve push(d, d') + M(t) d'' = load + friction(speed - d') by the trapezoidal rule.

    The gear follows the load slowly at first, as on an arm that has been moving. Links that
    stick stay where they are: each step is solved with the friction at its end.

    Args:
        t: (samples,) time [s].
        load: (samples,) torque that the links need without that friction [N m].
        inertia: (samples,) M of the links, positive [kg m^2].
        gear: K [N m/rad] of a spring K (x + stiffening x^3), D on a flank [N m s/rad], half the
            gap [rad], stiffening [1/rad^2].
        brake: (samples,) speed of the motor [rad/s]; Coulomb friction [N m], width of its sign
            [rad/s] and viscous friction [N m s/rad], none of them negative.

    Returns:
        (samples,) d [rad], d' and d''.
    """
    stiffness, damping, half, stiffening = gear
    speed, coulomb, width, viscous = brake
    sign = (coulomb, width)
    d, v, a = np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t))
    first = load[0] + viscous * speed[0]
    first += coulomb * np.tanh(speed[0] / width)
    settled = _at_rest(first / stiffness, stiffening)
    d[0] = settled + half * np.sign(first)
    few = min(len(t) - 1, 10)
    if few > 0:
        slope = stiffness * (1 + 3 * stiffening * settled * settled)
        v[0] = (load[few] - load[0]) / (t[few] - t[0]) / slope
    for k in range(1, len(t)):
        h = (t[k] - t[k - 1]) / 2
        rate = v[k - 1] + h * a[k - 1]
        place = d[k - 1] + h * (v[k - 1] + rate)
        links = speed[k] - rate
        needed = load[k] + viscous * links
        heavy = inertia[k] + h * viscous
        flank = half if place > 0 else -half
        if half > 0.0 and abs(place) <= half + h * h * (abs(needed) + coulomb) / heavy:
            # Free of the gear it may land on either flank, or on none.
            a[k] = _against_coulomb((needed, heavy), (links, h), sign)
            flank = min(max(place + h * h * a[k], -half), half)
        if abs(flank) == half:
            needed -= damping * rate
            heavy += h * damping
            # Newton steps by the spring's tangent: one is all where it does not stiffen.
            x = place - flank + h * h * a[k - 1]
            for _ in range(MOST_STEPS):
                bent = stiffening * x * x
                tangent = stiffness * (1 + 3 * bent)
                pushed = needed - tangent * (place - flank) + 2 * stiffness * bent * x
                a[k] = _against_coulomb((pushed, heavy + h * h * tangent), (links, h), sign)
                moved = abs(place - flank + h * h * a[k] - x)
                x = place - flank + h * h * a[k]
                if stiffening == 0.0 or moved <= ROUNDING * abs(x):
                    break
        v[k] = rate + h * a[k]
        d[k] = place + h * h * a[k]
    return d, v, a


@kernel
@no_type_check
def _at_rest(x, stiffening):
    """Solve y + stiffening y^3 = x (Newton steps, which come down on it from x)."""
    y = x
    for _ in range(MOST_STEPS):
        y -= (y + stiffening * y**3 - x) / (1 + 3 * stiffening * y * y)
    return y


@kernel
@no_type_check
def _against_coulomb(equation, step, brake):
    """Solve heavy a = needed + coulomb tanh((links - h a) / width).

    Newton steps on the speed y = links - h a after the step, which a bracket holds: the equation
    rises with y, and where Coulomb friction lies between its bounds so does y.

    Args:
        equation: needed and heavy.
        step: links and h.
        brake: coulomb and width.
    """
    (needed, heavy), (links, h), (coulomb, width) = equation, step, brake
    if coulomb == 0.0:
        return needed / heavy
    low, high = links - h * (needed + coulomb) / heavy, links - h * (needed - coulomb) / heavy
    # The sign as a line within its width is near enough for a start.
    slope = coulomb / width
    y = links - h * (needed + slope * links) / (heavy + h * slope)
    if abs(y) > width:
        y = low if y > 0 else high
    for _ in range(MOST_STEPS):
        sign = np.tanh(y / width)
        excess = heavy * (y - links) / h + needed + coulomb * sign
        if excess > 0:
            high = y
        else:
            low = y
        after = y - excess / (heavy / h + coulomb * (1 - sign * sign) / width)
        if not low <= after <= high:
            after = (low + high) / 2
        moved = abs(after - y)
        y = after
        if moved <= EXACT * width:
            break
    return (needed + coulomb * np.tanh(y / width)) / heavy
