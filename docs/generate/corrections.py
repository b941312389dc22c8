"""What each correction of the appendix does, computed when the page is made."""

from vibroimpact.reproduce.appendix import CORRECTIONS, study


def pages():
    """The corrections, and [P] with and without each of them."""
    lines = ["| where | printed | correct |", "|---|---|---|"]
    lines += [
        f"| {where} | ${formula(printed)}$ | ${formula(right)}$ |"
        for where, printed, right in CORRECTIONS.values()
    ]
    lines += ["", "| motion | corrected | max\\|λ\\| | det[P] | law | largest error of a $[P_i]$ |",
              "|---|---|---|---|---|---|"]  # fmt: skip
    for row in study():
        done = ", ".join(row["corrected"]) or "nothing"
        lines.append(
            f"| {row['motion']} | {done} | {row['multipliers'][0]:.4f} | {row['determinant']:.4f} "
            f"| {row['law']:.4f} | {power(row['largest_error'])} |"
        )
    return {"corrections.md": "\n".join(lines) + "\n"}


def formula(text):
    """A printed term in TeX."""
    for plain, tex in (("X'_ia", r"{\dot X}_{ia}"), ("Z'_ia", r"{\dot Z}_{ia}"), ("Omega", r"\Omega"),
                       ("S_6i", "S_{6i}"), ("S_3i", "S_{3i}")):  # fmt: skip
        text = text.replace(plain, tex)
    return text


def power(x):
    """A small number by its power of ten, which does not depend on the last bits of the machine."""
    return f"{x:.2g}" if x > 1e-12 else "below 10⁻¹²"
