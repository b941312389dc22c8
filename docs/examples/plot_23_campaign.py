r"""
A campaign over four parameters
===============================

max\|X\|/A of an impact damper near resonance, for 2 damping ratios, 5 mass ratios, 5 coefficients of restitution
and 10 clearances: 500 responses. Several attractors can coexist; the worst one counts. The map shows the least
value that a choice of the clearance (the whole travel of the free mass) can give.
"""

import pathlib
import tempfile

import matplotlib.pyplot as plt
import numpy as np
import vibroimpact as vi

osc = vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75)
case = vi.response(osc, [0.98, 1.0, 1.02], clearance=20, states=6, settling=200).to_namelist()
sweep = vi.Sweep(
    case,
    {
        "xi": [0.005, 0.02],
        "mu": np.geomspace(0.02, 0.2, 5),
        "restitution": [0.3, 0.45, 0.6, 0.75, 0.9],
        "clearance": np.geomspace(4, 160, 10),
    },
)
store = pathlib.Path(tempfile.mkdtemp()) / "store"
found = vi.campaign(sweep, store)
print(found)

# %%
# The same call continues a campaign that was interrupted, or killed. The values of all cases form a labelled
# array:

worst = found.to_xarray("points", "highest", "max")
least = worst.min("response.clearance")

figure, axes = plt.subplots(1, 2, figsize=(7.2, 3.2), sharey=True, layout="constrained")
for ax, xi in zip(axes, sweep.axes[0], strict=True):
    part = least.sel({"system.xi": xi})
    image = ax.pcolormesh(
        part["system.restitution"],
        part["system.mu"],
        part,
        vmin=0,
        vmax=1,
        cmap="cividis",
        shading="nearest",
    )
    ax.set(title=f"ξ = {xi:g}", xlabel="restitution  R", yscale="log")
axes[0].set_yticks([0.02, 0.05, 0.1, 0.2], ["0.02", "0.05", "0.1", "0.2"], minor=False)
axes[0].set_yticks([], minor=True)
axes[0].set_ylabel("mass ratio  μ = m/M")
figure.colorbar(image, ax=axes, label="least max|X|/A over the clearance", extend="max")
