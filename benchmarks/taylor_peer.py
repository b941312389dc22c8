"""The peer heyoka: adaptive Taylor integration, compiled for each system, with zeros of its polynomials as events.

The polynomials of its steps have an error of 2^-52, and all zeros of an event in a step are isolated. Impacts are
callbacks in Python, as a user would write them.
"""

import math
from importlib.util import find_spec

import numpy as np

NAME = "heyoka"


def here():
    """Whether heyoka is installed."""
    return find_spec(NAME) is not None


def hosts_and_particles(stiffness, forces, mass, opening, restitution, damping=0.0):
    """An integrator of hosts of mass 1, each with a free particle between two walls, and its list of impact times.

    `stiffness` couples the hosts; `forces` are expressions of heyoka's time; `damping` is that of each host.
    """
    import heyoka as hy

    n = len(stiffness)
    names = [f"{kind}{i}" for kind in "xvzw" for i in range(n)]
    variables = hy.make_vars(*names)
    x, v, z, w = (variables[k * n : (k + 1) * n] for k in range(4))
    times = []

    def bounce(host):
        def callback(integrator, *_):
            state = integrator.state
            before, after = state[n + host], state[3 * n + host]
            approach = after - before
            momentum = before + mass * after
            state[n + host] = (momentum + mass * restitution * approach) / (1 + mass)
            state[3 * n + host] = state[n + host] - restitution * approach
            times.append(integrator.time)
            return True

        return callback

    equations = []
    for i in range(n):
        pull = sum(float(stiffness[i, j]) * x[j] for j in range(n) if stiffness[i, j])
        equations += [(x[i], v[i]), (v[i], forces[i] - damping * v[i] - pull)]
        equations += [(z[i], w[i]), (w[i], hy.expression(0.0))]
    order = {str(variable): at for at, (variable, _) in enumerate(equations)}
    equations = [equations[order[name]] for name in names]
    events = []
    for i in range(n):
        for side in (1, -1):
            gap = opening - side * (z[i] - x[i])
            events.append(
                hy.t_event(gap, callback=bounce(i), direction=hy.event_direction.negative)
            )
    return hy.taylor_adaptive(equations, np.zeros(4 * n), t_events=events), times


def oscillator(xi, mu, restitution, r, clearance):
    """An integrator of the oscillator, and its list of impact times."""
    import heyoka as hy

    force = hy.sin(r * hy.time)
    return hosts_and_particles(
        np.ones((1, 1)), [force], mu, clearance / 2, restitution, damping=2 * xi
    )


def simulate(xi, mu, restitution, r, clearance, cycles):
    """Impact times of so many cycles from rest, by a function that can be called again and again."""
    integrator, times = oscillator(xi, mu, restitution, r, clearance)

    def run():
        times.clear()
        restart(integrator, 0.0, 0.0)
        integrator.propagate_until(2 * math.pi * cycles / r)
        return list(times)

    return run


def switching(equations, events, regimes, start=0.0):
    """Times of events up to an end, by a function that can be called again and again.

    `equations` and `events` are functions of x, v and the regime (`par[0]`). `regimes` are functions of the time,
    the state and the regime that give the next one, one for each event. A run starts from rest at 0 in the regime
    `start`.
    """
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    times = []

    def change(regime):
        def callback(integrator, *_):
            integrator.pars[0] = regime(integrator.time, integrator.state, integrator.pars[0])
            times.append(integrator.time)
            return True

        return callback

    found = [
        hy.t_event(event, callback=change(regime), direction=hy.event_direction.negative)
        for event, regime in zip(events(x, v, hy.par[0]), regimes, strict=True)
    ]
    velocity, acceleration = equations(x, v, hy.par[0])
    integrator = hy.taylor_adaptive(
        [(x, velocity), (v, acceleration)], [0.0, 0.0], t_events=found, pars=[start]
    )

    def run(end):
        times.clear()
        integrator.pars[0] = start
        restart(integrator, 0.0, 0.0)
        integrator.propagate_until(end)
        return np.array(times)

    return run


def restart(integrator, time, state):
    """Set an integrator to a time and a state."""
    integrator.time = time
    integrator.state[:] = state
    integrator.reset_cooldowns()
