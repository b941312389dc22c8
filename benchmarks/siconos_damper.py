"""Impacts by the event-driven scheme of Siconos, run by the Python that has it (Debian's python3-siconos).

    python3 benchmarks/siconos_damper.py XI MU R RESTITUTION CLEARANCE CYCLES

prints the number of impacts from rest and the CPU seconds that they took. The load is a plugin in C, so that no
time goes into Python; lsodar integrates and looks for sign changes of the gaps.
"""

import math
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
import siconos.kernel as sk

LOAD = """#include <math.h>
void load(double time, unsigned int size, double *force, unsigned int n, double *z)
{ force[0] = sin(z[0] * time); force[1] = 0.0; }
"""
#: Kind of an event at which a gap closes.
CONTACT = 2
#: By how far a gap may be below zero at a contact.
OVERSHOOT = 1e-8


def impacts(xi, mu, r, restitution, clearance, cycles, library):
    """Number of impacts from rest."""
    zero, end = np.zeros(2), 2 * math.pi * cycles / r
    masses, springs, dampers = np.diag([1, mu]), np.diag([1.0, 0]), np.diag([2 * xi, 0])
    system = sk.LagrangianLinearTIDS(zero, zero, masses, springs, dampers)
    system.setzPtr(np.array([r]))
    system.setComputeFExtFunction(library, "load")
    model = sk.NonSmoothDynamicalSystem(0.0, end)
    model.insertDynamicalSystem(system)
    law = sk.NewtonImpactNSL(restitution)
    for side in (1.0, -1.0):
        gap = sk.LagrangianLinearTIR(np.array([[side, -side]]), np.array([0.5 * clearance]))
        model.link(sk.Interaction(law, gap), system)
    simulation = sk.EventDriven(model, sk.TimeDiscretisation(0.0, end / cycles))
    simulation.insertIntegrator(sk.LsodarOSI())
    simulation.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_IMPACT)
    simulation.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_SMOOTH_ACC)
    simulation.setToleranceED(OVERSHOOT)
    simulation.initialize()
    events, n = simulation.eventsManager(), 0
    while simulation.hasNextEvent():
        simulation.advanceToEvent()
        n += events.nextEvent().getType() == CONTACT
        simulation.processEvents()
    return n


def main():
    """Build the load, simulate, print."""
    xi, mu, r, restitution, clearance = map(float, sys.argv[1:6])
    with tempfile.TemporaryDirectory() as folder:
        source, library = os.path.join(folder, "load.c"), os.path.join(folder, "load.so")
        with open(source, "w", encoding="utf-8") as file:
            file.write(LOAD)
        subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
        begin = time.process_time()
        n = impacts(xi, mu, r, restitution, clearance, int(sys.argv[6]), library)
        print(n, time.process_time() - begin)


if __name__ == "__main__":
    main()
