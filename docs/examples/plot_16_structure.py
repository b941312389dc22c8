r"""
A chain of cells with free masses
=================================

Twenty masses in a row, with springs between neighbours, carry a free mass each, in a slot that leaves 1 on
each side; all impacts are elastic. `simulate` takes such a :class:`~vibroimpact.Structure` of any number of
masses, springs, dashpots and gaps. The first mass gets a velocity.
"""

import numpy as np
import vibroimpact as vi

cells = 20
stiffness = np.zeros((2 * cells, 2 * cells))
for i in range(cells - 1):
    stiffness[i : i + 2, i : i + 2] += [[1, -1], [-1, 1]]
gaps = []
for i in range(cells):
    direction = np.zeros(2 * cells)
    direction[[i, cells + i]] = -1, 1
    gaps += [vi.Gap(direction, 1.0), vi.Gap(-direction, 1.0)]
chain = vi.Structure([1.0] * cells + [0.3] * cells, np.zeros(2 * cells), stiffness, gaps)

velocity = np.zeros(2 * cells)
velocity[0] = -2.0
run = vi.simulate(chain, duration=60, state=(np.zeros(2 * cells), velocity))
print(run)

# %%
# A wave of impacts runs along the chain at the speed of sound of its springs, and much of the energy stays behind
# with the first free mass, which collides with both walls of its slot again and again. The energy is kept to
# rounding.

run.plot()

q, q_dot = run.sample([0.0, 60.0])
kinetic = 0.5 * np.einsum("it,ij,jt->t", q_dot, chain.mass, q_dot)
elastic = 0.5 * np.einsum("it,ij,jt->t", q, chain.stiffness, q)
print(f"energy at the start and at the end: {kinetic + elastic}")
