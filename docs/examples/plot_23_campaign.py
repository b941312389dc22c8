r"""
A campaign over four parameters
===============================

max\|X\|/A of an impact damper near resonance, for 2 damping ratios, 5 mass ratios, 5 coefficients of
restitution and 14 clearances: 700 responses. Several attractors can coexist; the worst one at the worst of
three frequency ratios counts. The map shows the smallest value that can be reached by the choice of the clearance
d (the whole travel of the free mass).
"""

import pathlib
import tempfile

import matplotlib.pyplot as plt
import numpy as np
import vibroimpact as vi

osc = vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75)
case = vi.response(osc, [0.98, 1.0, 1.02], clearance=20, states=6, settling=300).to_namelist()
sweep = vi.Sweep(
    case,
    {
        "xi": [0.005, 0.02],
        "mu": np.geomspace(0.02, 0.2, 5),
        "restitution": [0.3, 0.45, 0.6, 0.75, 0.9],
        "clearance": np.geomspace(8, 120, 14),
    },
)
store = pathlib.Path(tempfile.mkdtemp()) / "store"
found = vi.campaign(sweep, store)
print(found)

# %%
# The same call resumes a campaign that was interrupted or killed. The values of all cases form labelled
# arrays. Each cell of the map shows the clearance d K/F0 of its least value, with a star if other attractors
# coexist there at one of the frequency ratios: their max\|X\|/A is lower by 10 % or more.

rows = found.to_xarray("points")
several = np.zeros(found.size, dtype=bool)
np.logical_or.at(several, rows["case"].values, (rows["lowest"] < 0.9 * rows["highest"]).values)
several = several.reshape(found.shape)

worst = found.to_xarray("points", "highest", "max")
least, place = worst.min("response.clearance"), worst.argmin("response.clearance").values
xi, mu, restitution, clearance = sweep.axes

figure, axes = plt.subplots(1, 2, figsize=(7.2, 3.2), sharey=True, layout="constrained")
for i, ax in enumerate(axes):
    image = ax.imshow(least[i], vmin=0, vmax=1, cmap="cividis", origin="lower", aspect="auto")
    for (j, k), best in np.ndenumerate(place[i]):
        star = "*" if several[i, j, k, best] else ""
        colour = "white" if least[i, j, k] < 0.6 else "black"
        ax.text(
            k, j, f"{clearance[best]:.0f}{star}", color=colour, ha="center", va="center", fontsize=8
        )
    ax.set_title(f"ξ = {xi[i]:g}")
    ax.set_xlabel("coefficient of restitution R")
    ax.set_xticks(range(len(restitution)), [f"{x:g}" for x in restitution])
axes[0].set_yticks(range(len(mu)), [f"{x:.2g}" for x in mu])
axes[0].set_ylabel("mass ratio μ = m/M")
figure.colorbar(image, ax=axes, label="least max|X|/A over the clearance", extend="max")
