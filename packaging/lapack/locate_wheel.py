"""Print the folder of the shared library in the PyPI package scipy-openblas32; fail if it is not installed."""

import scipy_openblas32

print(scipy_openblas32.get_lib_dir())
