"""Calls of all forms as a user with a type checker writes them; they are checked by mypy, and never run."""

from typing import assert_type

import numpy as np
import vibroimpact as vi

rig = vi.Oscillator.from_dimensional(
    M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
)
point = rig.at("19.5 Hz", "4 mm")
assert_type(vi.equispaced(point), list[vi.Motion])
run = vi.simulate(point, 30)
assert_type(run, vi.Trajectory)
run = vi.simulate(point, cycles=30, discard=10)
motion = vi.exact(point, run)
assert_type(motion, vi.Motion)
assert_type(vi.exact(point, ([0.0, 3.0], "RL")), vi.Motion)
assert_type(vi.find(point, max_impacts=2), vi.FoundMotions)
assert_type(vi.lyapunov(point, cycles=100), vi.Lyapunov)
assert_type(
    vi.bifurcation_diagram(point, "clearance", ("2 mm", "5 mm"), points=11), vi.BifurcationDiagram
)
assert_type(vi.response(point, ("18 Hz", "21 Hz"), points=11), vi.Response)
assert_type(vi.basins(point, states=100), vi.Basins)
assert_type(
    vi.basins(point, (("x", ("-3 mm", "3 mm")), ("x_dot", ("-1 m/s", "1 m/s"))), points=20),
    vi.Basins,
)
assert_type(vi.uncertainty(point, "RL", {"restitution": (0.7, 0.8)}, bands=False), vi.Uncertainty)
assert_type(
    vi.limit_probability(point, {"restitution": (0.7, 0.8)}, {"displacement": 3.0}),
    vi.LimitProbability,
)
assert_type(vi.prove_box(point, "RL"), vi.Certificate)
assert_type(vi.prove_all(point), vi.Certificate)
assert_type(vi.simulate_bundle(point, 10), vi.Bundle)
assert_type(vi.equispaced_batch(point), tuple[vi.Motions, vi.Motions])
# of an oscillator, with units
assert_type(vi.simulate(rig, "19.5 Hz", "4 mm", 30), vi.Trajectory)
assert_type(vi.find(rig, "19.5 Hz", "4 mm"), vi.FoundMotions)
assert_type(vi.zone(rig, "RL", r=("18 Hz", "21 Hz"), clearance=("2 mm", "6 mm")), vi.Zone)
assert_type(vi.atlas(rig, r=("18 Hz", "21 Hz"), clearance=("2 mm", "6 mm")), vi.Atlas)
assert_type(vi.branch(motion, "clearance", ("2 mm", "6 mm")), vi.Branch)
assert_type(vi.equispaced(rig, "19.5 Hz", "4 mm"), list[vi.Motion])
assert_type(vi.response(rig, ("18 Hz", "21 Hz"), "4 mm", points=11), vi.Response)
assert_type(vi.decay(rig, "4 mm", amplitude="2 mm"), vi.Decay)
# of a structure
beam = vi.Structure([1.0, 0.1], [0.02, 0], [1.0, 0], [vi.Gap([-1, 1], 0.5, 0.8)])
load = vi.Load(1.0, sine=[1, 0])
assert_type(vi.simulate(beam, load, cycles=10), vi.Trajectory)
m2 = vi.exact(beam, load, ([0.1], [0]))
assert_type(m2, vi.Motion)
assert_type(vi.branch(m2, "frequency", (0.9, 1.1)), vi.Branch)
assert_type(vi.zone(m2, x=("frequency", (0.9, 1.1)), y=("opening", (0.2, 1.0))), vi.Zone)
assert_type(vi.atlas(beam, load, x=("frequency", (0.9, 1.1)), y=("opening", (0.2, 1.0))), vi.Atlas)
assert_type(vi.find(beam, load), vi.FoundMotions)
assert_type(vi.periodic(beam, load, [0.1], [0]), vi.Motion)
assert_type(vi.basins(beam, load, states=4), vi.Basins)
assert_type(vi.lyapunov(beam, load), vi.Lyapunov)
assert_type(vi.response(beam, load, np.linspace(0.9, 1.1, 3)), vi.Response)
assert_type(vi.bifurcation_diagram(beam, load, "frequency", [0.9, 1.0]), vi.BifurcationDiagram)
