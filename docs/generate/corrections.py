"""The effect of each correction of the appendix, computed when the page is made."""

import re

from vibroimpact.reproduce.appendix import CORRECTIONS, study


def pages():
    """The corrections, and [P] with and without each of them."""
    lines = ["| where | printed | correct |", "|---|---|---|"]
    lines += [
        f"| ${formula(where.split(' in ')[0])}$ in {where.split(' in ')[1]} | ${formula(printed)}$ "
        f"| ${formula(right)}$ |"
        for where, printed, right in CORRECTIONS.values()
    ]
    lines += ["", "| motion | printed are | max\\|λ\\|, lengths in $F_0/K$ | with $d = 37$ "
              "| $\\det [P]$ | by the law | largest error of a $[P_i]$ |",
              "|---|---|---|---|---|---|---|"]  # fmt: skip
    for row in study():
        printed = [formula(CORRECTIONS[name][0].split(" in ")[0])
                   for name in CORRECTIONS if name not in row["corrected"]]  # fmt: skip
        left = "all three" if len(printed) == 3 else ", ".join(f"${name}$" for name in printed)
        lines.append(
            f"| {row['motion']} | {left or 'none'} | {row['multipliers'][0]:.4f} "
            f"| {row['largest_in_table_1']:.4f} | {number(row['determinant'])} | {row['law']:.4f} "
            f"| {power(row['largest_error'])} |"
        )
    return {"corrections.md": "\n".join(lines) + "\n"}


def formula(text):
    """A printed term in TeX."""
    for plain, tex in (("X'_ia", r"{\dot X}_{ia}"), ("Z'_ia", r"{\dot Z}_{ia}"), ("Omega", r"\Omega"),
                       ("P_ia(3,1)", "P_{ia}(3,1)")):  # fmt: skip
        text = text.replace(plain, tex)
    return re.sub(r"S_(\d+i)", r"S_{\1}", text)


def number(x):
    """Four decimals, with a minus sign, and no sign at 0."""
    return f"{round(x, 4) + 0:.4f}".replace("-", "−")


def power(x):
    """A small number by its power of ten, which does not depend on the last bits of the machine."""
    return f"{x:.2g}" if x > 1e-12 else "below 10⁻¹²"
