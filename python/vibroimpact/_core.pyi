# The procedures of python/boundary, which describes their arguments; written by .ci/check_stub.py. At
# run time each is an object of f2py's that can be called, not a function: hence a protocol for each.

from typing import Protocol, TypeAlias, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Real: TypeAlias = NDArray[np.float64]
_Complex: TypeAlias = NDArray[np.complex128]
_Integer: TypeAlias = NDArray[np.intc]
_Bytes: TypeAlias = NDArray[np.bytes_]

__f2py_numpy_version__: str

@type_check_only
class _AddNotesOf(Protocol):
    def __call__(
        self,
        handle: int,
        text: ArrayLike,
        n: int = ...,
    ) -> None: ...

@type_check_only
class _CompleteRests(Protocol):
    # status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        labels: ArrayLike,
        starts: _Real,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        m: int = ...,
    ) -> int: ...

@type_check_only
class _DescribeLanguage(Protocol):
    # text, length
    def __call__(
        self,
        capacity: int,
    ) -> tuple[_Bytes, int]: ...

@type_check_only
class _DescribeResult(Protocol):
    # text, length
    def __call__(
        self,
        handle: int,
        capacity: int,
    ) -> tuple[_Bytes, int]: ...

@type_check_only
class _EndOfTrajectory(Protocol):
    # cycles, n, symbols, first, apart, n_own, own_cycles, own_sides, restitution, phases, impacts,
    # scalars, multipliers, verdicts, n_events, own_values, own_labels, status
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: float,
        load: float,
        clearance: float,
        of_simulation: ArrayLike,
        values: ArrayLike,
        labels: ArrayLike,
        most_cycles: int,
        tolerance: float,
        solve: int,
        capacity: int,
        m: int = ...,
    ) -> tuple[
        int,
        int,
        _Integer,
        _Integer,
        float,
        int,
        int,
        _Integer,
        _Real,
        _Real,
        _Real,
        _Real,
        _Complex,
        _Integer,
        int,
        _Real,
        _Integer,
        int,
    ]: ...

@type_check_only
class _Equispaced(Protocol):
    # impacts, scalars, multipliers, verdicts, status
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
    ) -> tuple[_Real, _Real, _Complex, _Integer, _Integer]: ...

@type_check_only
class _EquispacedChart(Protocol):
    # scalars, multipliers, verdicts, status
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: ArrayLike,
        clearance: ArrayLike,
        cycles: int,
        with_multipliers: int,
        threads: int,
        m: int = ...,
        n: int = ...,
    ) -> tuple[_Real, _Complex, _Integer, _Integer]: ...

@type_check_only
class _Exact(Protocol):
    # phases, impacts, scalars, multipliers, verdicts, status, iterations
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: float,
        load: float,
        clearance: float,
        cycles: int,
        sides: ArrayLike,
        restitution: ArrayLike,
        x: ArrayLike,
        theta: ArrayLike,
        most: int,
        n: int = ...,
    ) -> tuple[_Real, _Real, _Real, _Complex, _Integer, int, int]: ...

@type_check_only
class _FillReals(Protocol):
    def __call__(
        self,
        handle: int,
        names: ArrayLike,
        values: ArrayLike,
        n: int = ...,
    ) -> None: ...

@type_check_only
class _FillWholes(Protocol):
    def __call__(
        self,
        handle: int,
        names: ArrayLike,
        values: ArrayLike,
        words: ArrayLike,
        n: int = ...,
        m: int = ...,
    ) -> None: ...

@type_check_only
class _FindMotion(Protocol):
    # changed, n_own, own_cycles, own_sides, restitution, phases, impacts, scalars, multipliers,
    # verdicts, n_events, values, labels, status
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: float,
        load: float,
        clearance: float,
        cycles: int,
        sides: ArrayLike,
        unknowns: ArrayLike,
        releases: ArrayLike,
        form: int,
        capacity: int,
        n: int = ...,
        m: int = ...,
    ) -> tuple[
        int,
        int,
        int,
        _Integer,
        _Real,
        _Real,
        _Real,
        _Real,
        _Complex,
        _Integer,
        int,
        _Real,
        _Integer,
        int,
    ]: ...

@type_check_only
class _FreeResult(Protocol):
    def __call__(
        self,
        handle: int,
    ) -> None: ...

@type_check_only
class _ImpactMaps(Protocol):
    # p, regular
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
    ) -> tuple[_Real, int]: ...

@type_check_only
class _LeastClearance(Protocol):
    # least
    def __call__(
        self,
        xi: float,
        r: float,
        load: float,
        x: float,
    ) -> float: ...

@type_check_only
class _LinearSystem(Protocol):
    # matrix, rhs
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
    ) -> tuple[_Real, _Real]: ...

@type_check_only
class _MotionGradient(Protocol):
    # values, slopes, codes, status
    def __call__(
        self,
        m: int,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: float,
        load: float,
        clearance: float,
        cycles: int,
        sides: ArrayLike,
        restitution: ArrayLike,
        x: ArrayLike,
        theta: ArrayLike,
        multipliers: ArrayLike,
        n: int = ...,
    ) -> tuple[_Real, _Real, _Integer, int]: ...

@type_check_only
class _NarrowGap(Protocol):
    # gap, least
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        q: ArrayLike,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
    ) -> tuple[int, float]: ...

@type_check_only
class _NewResult(Protocol):
    # handle, status
    def __call__(
        self,
        text: ArrayLike,
        study: ArrayLike,
        model: int,
        n: int = ...,
    ) -> tuple[int, int]: ...

@type_check_only
class _OpenTable(Protocol):
    def __call__(
        self,
        handle: int,
        names: ArrayLike,
        sizes: ArrayLike,
        owners: ArrayLike,
        n: int = ...,
        m: int = ...,
    ) -> None: ...

@type_check_only
class _Perform(Protocol):
    # found, ends, counts, status
    def __call__(
        self,
        parameters: ArrayLike,
        places: ArrayLike,
        settling: int,
        keep: int,
        max_events: int,
        threads: int,
        wanted: ArrayLike,
        progress: _Integer,
        n: int = ...,
    ) -> tuple[_Real, _Real, _Integer, _Integer]: ...

@type_check_only
class _Periodic(Protocol):
    # impacts, scalars, multipliers, verdicts, status
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
    ) -> tuple[_Real, _Real, _Complex, _Integer, _Integer]: ...

@type_check_only
class _PeriodicStructure(Protocol):
    # impacts, states, p, multipliers, scalars, verdicts, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        at: ArrayLike,
        phases: ArrayLike,
        cycles: int,
        wanted: int,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        m: int = ...,
    ) -> tuple[_Real, _Real, _Real, _Complex, _Real, _Integer, int]: ...

@type_check_only
class _ReadNamelist(Protocol):
    # handle, status
    def __call__(
        self,
        path: ArrayLike,
        n_path: int = ...,
    ) -> tuple[int, int]: ...

@type_check_only
class _RestingAtStart(Protocol):
    # rests, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        step: float,
        record: ArrayLike,
        start: ArrayLike,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        samples: int = ...,
    ) -> tuple[_Integer, int]: ...

@type_check_only
class _RestitutionValues(Protocol):
    # values, slopes
    def __call__(
        self,
        kind: float,
        numbers: ArrayLike,
        speeds: ArrayLike,
        width: int = ...,
        m: int = ...,
    ) -> tuple[_Real, _Real]: ...

@type_check_only
class _RunCase(Protocol):
    # handle, status
    def __call__(
        self,
        text: ArrayLike,
        threads: int,
        progress: _Integer,
        n: int = ...,
    ) -> tuple[int, int]: ...

@type_check_only
class _RunNamelists(Protocol):
    # handle, status
    def __call__(
        self,
        paths: ArrayLike,
        folder: ArrayLike,
        only: ArrayLike,
        progress: _Integer,
        n_paths: int = ...,
        n_folder: int = ...,
    ) -> tuple[int, int]: ...

@type_check_only
class _SameImpacts(Protocol):
    # same
    def __call__(
        self,
        gaps: ArrayLike,
        phases: ArrayLike,
        speeds: ArrayLike,
        other_gaps: ArrayLike,
        other_phases: ArrayLike,
        other_speeds: ArrayLike,
        cycles: int,
        rests: int,
        n: int = ...,
        m: int = ...,
    ) -> int: ...

@type_check_only
class _SameMotion(Protocol):
    # are_one
    def __call__(
        self,
        xi: float,
        r: float,
        load: float,
        clearance: float,
        cycles: int,
        sides: ArrayLike,
        unknowns: ArrayLike,
        releases: ArrayLike,
        other_sides: ArrayLike,
        other_unknowns: ArrayLike,
        other_releases: ArrayLike,
        mirror: int,
        n: int = ...,
        m: int = ...,
    ) -> int: ...

@type_check_only
class _Sample(Protocol):
    # values
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
    ) -> _Real: ...

@type_check_only
class _SampleStructure(Protocol):
    # values, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        step: float,
        record: ArrayLike,
        starts: ArrayLike,
        labels: ArrayLike,
        times: ArrayLike,
        parts: int,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        samples: int = ...,
        m: int = ...,
        k: int = ...,
    ) -> tuple[_Real, int]: ...

@type_check_only
class _SampleTrajectory(Protocol):
    # values
    def __call__(
        self,
        xi: float,
        mu: float,
        r: float,
        load: float,
        clearance: float,
        starts: ArrayLike,
        resting: ArrayLike,
        times: ArrayLike,
        n: int = ...,
        m: int = ...,
    ) -> _Real: ...

@type_check_only
class _SettleStructure(Protocol):
    # counts, labels, impacts, states, rests, p, multipliers, scalars, verdicts, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        start: float,
        state: ArrayLike,
        settling: int,
        most_cycles: int,
        cycles: int,
        capacity: int,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
    ) -> tuple[_Integer, _Integer, _Real, _Real, _Real, _Real, _Complex, _Real, _Integer, int]: ...

@type_check_only
class _ShiftBoundary(Protocol):
    # normals, slopes, shifts, outcomes, status
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        cycles: int,
        sides: ArrayLike,
        symmetric: int,
        window: ArrayLike,
        types: ArrayLike,
        indices: ArrayLike,
        places: ArrayLike,
        x: ArrayLike,
        theta: ArrayLike,
        changes: ArrayLike,
        threads: int,
        progress: _Integer,
        n: int = ...,
        v: int = ...,
        most: int = ...,
        s: int = ...,
    ) -> tuple[_Real, _Real, _Real, _Integer, _Integer]: ...

@type_check_only
class _SidePatterns(Protocol):
    # n, impacts, cycles, sides
    def __call__(
        self,
        max_impacts: int,
        max_cycles: int,
        alike: int,
        capacity: int,
    ) -> tuple[int, _Integer, _Integer, _Integer]: ...

@type_check_only
class _Simulate(Protocol):
    # n_events, last_state, last_contact, end_state, end_contact, status
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: float,
        load: float,
        clearance: float,
        state: ArrayLike,
        contact: ArrayLike,
        last_cycle: float,
        last_phase: float,
        names: ArrayLike,
        table: _Real,
        capacity: int = ...,
    ) -> tuple[int, _Real, _Integer, _Real, _Integer, int]: ...

@type_check_only
class _SimulateBundle(Protocol):
    # ends, counts, status
    def __call__(
        self,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: ArrayLike,
        load: ArrayLike,
        clearance: ArrayLike,
        cycles: float,
        most_events: int,
        threads: int,
        starts: ArrayLike,
        progress: _Integer,
        m: int = ...,
    ) -> tuple[_Real, _Integer, _Integer]: ...

@type_check_only
class _SimulateStructure(Protocol):
    # n_events, first_state, end_state, end_time, resting, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        step: float,
        record: ArrayLike,
        start: float,
        state: ArrayLike,
        first: float,
        last: float,
        table: _Real,
        labels: _Integer,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        samples: int = ...,
        capacity: int = ...,
    ) -> tuple[int, _Real, _Real, float, _Integer, int]: ...

@type_check_only
class _Spaced(Protocol):
    # values
    def __call__(
        self,
        n: int,
        low: float,
        high: float,
        geometric: int,
    ) -> _Real: ...

@type_check_only
class _StabilityFlags(Protocol):
    # consistent, stable, radius, status, referred
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
        with_radius: int,
        threads: int,
        wide: int,
        n: int = ...,
        m: int = ...,
    ) -> tuple[_Integer, _Integer, _Real, _Integer, int]: ...

@type_check_only
class _StartState(Protocol):
    # state, contact
    def __call__(
        self,
        xi: float,
        r: float,
        load: float,
        clearance: float,
        start: ArrayLike,
    ) -> tuple[_Real, _Integer]: ...

@type_check_only
class _StatusText(Protocol):
    # text, length
    def __call__(
        self,
        code: int,
    ) -> tuple[_Bytes, int]: ...

@type_check_only
class _StructureGradient(Protocol):
    # values, finals, products, slopes, rates, opens, good, code, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        step: float,
        record: ArrayLike,
        entries: ArrayLike,
        by_entries: ArrayLike,
        by_record: ArrayLike,
        by_start: ArrayLike,
        starts: ArrayLike,
        labels: ArrayLike,
        speeds: ArrayLike,
        last: float,
        first: int,
        touched: int,
        sizes: ArrayLike,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        samples: int = ...,
        e: int = ...,
        p: int = ...,
        m: int = ...,
    ) -> tuple[_Real, _Real, _Real, _Real, _Real, _Integer, int, int, int]: ...

@type_check_only
class _StructureQuantities(Protocol):
    # numbers, parts, energies, share, status
    def __call__(
        self,
        matrices: ArrayLike,
        directions: ArrayLike,
        gap_values: ArrayLike,
        frequency: float,
        loads: ArrayLike,
        constant: ArrayLike,
        step: float,
        record: ArrayLike,
        starts: ArrayLike,
        labels: ArrayLike,
        window: ArrayLike,
        orders: int,
        n: int = ...,
        gaps: int = ...,
        width: int = ...,
        harmonics: int = ...,
        samples: int = ...,
        m: int = ...,
    ) -> tuple[_Real, _Complex, _Real, float, int]: ...

@type_check_only
class _SwitchBranch(Protocol):
    # found, lengths, all_cycles, all_sides, systems, all_phases, all_impacts, scalars, multipliers,
    # verdicts
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
        walls: ArrayLike,
        clearance: float,
        kind: int,
        flight: int,
        side: int,
        parameter: int,
        tied: int,
        n: int = ...,
    ) -> tuple[
        int, _Integer, _Integer, _Integer, _Real, _Real, _Real, _Real, _Complex, _Integer
    ]: ...

@type_check_only
class _TrajectoryGradient(Protocol):
    # by_events, by_finish, good
    def __call__(
        self,
        most: int,
        xi: float,
        mu: float,
        walls: ArrayLike,
        r: float,
        load: float,
        clearance: float,
        start: ArrayLike,
        contact: ArrayLike,
        finish: ArrayLike,
        finish_contact: ArrayLike,
        values: ArrayLike,
        labels: ArrayLike,
        n: int = ...,
    ) -> tuple[_Real, _Real, int]: ...

@type_check_only
class _Winding(Protocol):
    # turns
    def __call__(
        self,
        ring: ArrayLike,
        points: ArrayLike,
        n: int = ...,
        m: int = ...,
    ) -> _Integer: ...

@type_check_only
class _WritePrintout(Protocol):
    # message
    def __call__(
        self,
        handle: int,
        path: ArrayLike,
        n: int = ...,
    ) -> _Bytes: ...

@type_check_only
class _WriteResult(Protocol):
    # message
    def __call__(
        self,
        handle: int,
        path: ArrayLike,
        progress: _Integer,
        n: int = ...,
    ) -> _Bytes: ...

add_notes_of: _AddNotesOf
complete_rests: _CompleteRests
describe_language: _DescribeLanguage
describe_result: _DescribeResult
end_of_trajectory: _EndOfTrajectory
equispaced: _Equispaced
equispaced_chart: _EquispacedChart
exact: _Exact
fill_reals: _FillReals
fill_wholes: _FillWholes
find_motion: _FindMotion
free_result: _FreeResult
impact_maps: _ImpactMaps
least_clearance: _LeastClearance
linear_system: _LinearSystem
motion_gradient: _MotionGradient
narrow_gap: _NarrowGap
new_result: _NewResult
open_table: _OpenTable
perform: _Perform
periodic: _Periodic
periodic_structure: _PeriodicStructure
read_namelist: _ReadNamelist
resting_at_start: _RestingAtStart
restitution_values: _RestitutionValues
run_case: _RunCase
run_namelists: _RunNamelists
same_impacts: _SameImpacts
same_motion: _SameMotion
sample: _Sample
sample_structure: _SampleStructure
sample_trajectory: _SampleTrajectory
settle_structure: _SettleStructure
shift_boundary: _ShiftBoundary
side_patterns: _SidePatterns
simulate: _Simulate
simulate_bundle: _SimulateBundle
simulate_structure: _SimulateStructure
spaced: _Spaced
stability_flags: _StabilityFlags
start_state: _StartState
status_text: _StatusText
structure_gradient: _StructureGradient
structure_quantities: _StructureQuantities
switch_branch: _SwitchBranch
trajectory_gradient: _TrajectoryGradient
winding: _Winding
write_printout: _WritePrintout
write_result: _WriteResult
