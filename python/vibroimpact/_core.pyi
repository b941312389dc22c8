# The procedures of boundary.f90, which describes their arguments. At run time each is an object of
# f2py's that can be called, not a function: hence a protocol for each.

from typing import Protocol, TypeAlias, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Real: TypeAlias = NDArray[np.float64]
_Complex: TypeAlias = NDArray[np.complex128]
_Integer: TypeAlias = NDArray[np.intc]
_Bytes: TypeAlias = NDArray[np.bytes_]

# impacts, scalars, multipliers, verdicts, status
_Motions: TypeAlias = tuple[_Real, _Real, _Complex, _Integer, _Integer]

@type_check_only
class _Periodic(Protocol):
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: ArrayLike,
        cycles: int,
        sides: ArrayLike,
        restitution: ArrayLike,
        phases: ArrayLike,
        acceptance: float,
        single: int,
        flights: int,
        n: int = ...,
        m: int = ...,
    ) -> _Motions: ...

@type_check_only
class _Equispaced(Protocol):
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: ArrayLike,
        clearance: ArrayLike,
        cycles: int,
        acceptance: float,
        single: int,
        flights: int,
        m: int = ...,
    ) -> _Motions: ...

@type_check_only
class _LinearSystem(Protocol):
    def __call__(
        self,
        xi: float,
        mu: float,
        r: float,
        cycles: int,
        sides: ArrayLike,
        restitution: ArrayLike,
        phases: ArrayLike,
        n: int = ...,
    ) -> tuple[_Real, _Real]: ...  # matrix, rhs

@type_check_only
class _ImpactMaps(Protocol):
    def __call__(
        self,
        xi: float,
        mu: float,
        r: float,
        cycles: int,
        sides: ArrayLike,
        restitution: ArrayLike,
        phases: ArrayLike,
        impacts: ArrayLike,
        amplitude: float,
        tau: float,
        n: int = ...,
    ) -> tuple[_Real, int]: ...  # p, regular

@type_check_only
class _Sample(Protocol):
    def __call__(
        self,
        xi: float,
        mu: float,
        r: float,
        cycles: int,
        sides: ArrayLike,
        restitution: ArrayLike,
        phases: ArrayLike,
        impacts: ArrayLike,
        amplitude: float,
        tau: float,
        times: ArrayLike,
        n: int = ...,
        m: int = ...,
    ) -> _Real: ...  # values

@type_check_only
class _StatusText(Protocol):
    def __call__(self, code: int) -> tuple[_Bytes, int]: ...  # text, length

@type_check_only
class _RunNamelists(Protocol):
    def __call__(
        self,
        paths: ArrayLike,
        folder: ArrayLike,
        room: int,
        n_paths: int = ...,
        n_folder: int = ...,
    ) -> tuple[_Bytes, int, int]: ...  # text, length, status

__f2py_numpy_version__: str

periodic: _Periodic
equispaced: _Equispaced
linear_system: _LinearSystem
impact_maps: _ImpactMaps
sample: _Sample
status_text: _StatusText
run_namelists: _RunNamelists
