"""Print the path of the shared library of the package scipy-openblas32; fail if there is none."""

from pathlib import Path

import scipy_openblas32

print(Path(scipy_openblas32.get_lib_dir(), scipy_openblas32.get_library(fullname=True)).as_posix())
