"""Every procedure of the boundary gives the same bits from many Python threads at once as from one."""

import contextlib
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import after_impact
from shared_systems import RIG, TABLE
from shared_threads import THREADS, together
from vibroimpact import _core
from vibroimpact.formats.save import write_printout
from vibroimpact.results.performance import perform
from vibroimpact.studies.find import shares_of

ROUNDS = 5
PROCEDURES = {name for name in dir(_core) if type(getattr(_core, name)).__name__ == "fortran"}
#: Procedures that take the address of a result: `saved` calls them in order.
HANDLES = {
    "add_notes_of", "describe_result", "fill_reals", "fill_wholes", "free_result", "new_result", "open_table",
    "run_case", "write_printout", "write_result",
}  # fmt: skip
#: Procedures that read files: `test_threads` calls them from many threads.
FILES = {"read_namelist", "run_namelists"}


class Recorder:
    """Wrap a procedure, and keep copies of the arguments of its first calls."""

    def __init__(self, name):
        """Replace the procedure of this name."""
        self.procedure, self.calls = getattr(_core, name), []

    def __call__(self, *args, **options):
        """Keep the arguments, and call the procedure."""
        if len(self.calls) < 3:
            copies = [
                np.copy(arg, order="A") if isinstance(arg, np.ndarray) else arg for arg in args
            ]
            self.calls.append((copies, options))
        return self.procedure(*args, **options)


def saved(folder):
    """The bytes of files with a result of the core and with a motion, and the printout of a motion."""
    folder.mkdir(exist_ok=True)
    vi.decay(TABLE, 30.0, z_dot=2.0, cycles=5).save(folder / "decay.csv")
    motion = vi.equispaced(TABLE, 0.94, 37.0)[0]
    motion.save(folder / "motion.csv")
    case = vi.read_namelist(Path(__file__).parents[2] / "inputs/table1.nml")[0]
    write_printout(case.compute(), folder / "table1.txt")
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def public_calls(folder):
    """Quick calls of the package that reach every procedure."""
    saved(folder)
    vi.status_text(3)
    vi.spaced(2.0, 32.0, 5, "geometric")
    motion = vi.exact(TABLE, 0.94, 37.0, ([0, 4.3], "RL"))
    motion.sample([0.1, 0.2])
    motion.gradient()
    motion.impact_maps()
    vi.linear_system(TABLE, 0.94, [0, 4.3], "RL")
    vi.periodic(TABLE, 0.94, [0, 4.3], "RL")
    columns = np.array([[0.0] * 40, np.linspace(3, 5, 40)])
    vi.stability_flags(TABLE, np.full(40, 0.94), columns, vi.Pattern("RL"))
    vi.chart(TABLE, "RL", r=[0.9, 0.95], clearance=[30.0, 37.0])
    vi.same_motion(motion, motion)
    vi.standard_motion(motion)
    vi.motion_images(motion)
    # called by benchmarks, for the progress of a search, and once in a process
    _core.equispaced_chart(RIG.xi, RIG.mu, RIG.restitution, [0.9, 1.0], [20.0, 30.0], 1, 1, 1)
    shares_of(2, 1, True)
    _core.describe_language(1_000_000)
    vi.find(RIG, 0.9, 6.0, max_impacts=2, max_cycles=1, guesses=6, states=1, releases=0)
    run = vi.simulate(TABLE, 0.94, 37.0, 12, after_impact(motion))
    run.sample([5.0, 6.0])
    run.gradient()
    run.period()
    vi.simulate(TABLE, 0.94, 5e-9, 1e-3)  # a gap so narrow that rounding is compared with it
    vi.simulate_bundle(TABLE, [0.94, 0.95], 37.0, 3)
    vi.exact(RIG, 0.9, 6.0, vi.simulate(RIG, 0.9, 6.0, 4, discard=60))
    zone = vi.zone(RIG, "RL", (1.0, 1.1), (20.0, 60.0), lines=9)
    zone.contains(1.04, 30.0)
    branch = vi.branch(motion, "clearance", (20, 45))
    for point in branch.special_points:
        if point.type in ("pitchfork", "flip"):
            with contextlib.suppress(vi.errors.VibroimpactError):
                point.switch()
    vi.boundary_bands(zone, {"xi": (0.01, 0.012)}, samples=2, vertices=3)
    parameters = np.array([[0.94, 37.0, 0.005, 0.042, 0.75, 0.75]]).T
    perform(parameters, np.full((4, 1), 0.3), settling=40, keep=8)
    law = vi.PowerLaw(0.8, speed=0.1, exponent=0.25)
    law([0.1, 0.5])
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, law)])
    load = vi.Load(1.0, cosine=[1])
    known = vi.exact(wall, load, ([0.1], [0]))
    vi.same_motion(known, known)
    trajectory = vi.simulate(wall, load, cycles=100)
    trajectory.sample([1.0, 2.0])
    trajectory.acceleration([1.0])
    trajectory.quantities(harmonics=2)
    vi.simulate(wall, load, cycles=3).gradient(["load"])
    vi.exact(wall, load, trajectory)
    gaps = [vi.Gap([-1, 1], 1e-9, 0.8)]
    narrow = vi.Structure([1e-6, 2e-6], [0, 0], [[1, -1], [-1, 1]], gaps)
    with pytest.raises(vi.ParameterError, match="times the rounding error"):
        vi.simulate(narrow, vi.Load(1.0, sine=[1, 0]), duration=1e-8, state=([0, 0], [0, 1]))
    rests, load = (
        vi.Oscillator(xi=0.0114, mu=0.028, restitution=0).structure(6.0),
        vi.Load(0.9, sine=[1, 0]),
    )
    vi.exact(rests, load, vi.simulate(rests, load, cycles=200)).sample([1.0])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The calls of every procedure, by name."""
    recorders = {name: Recorder(name) for name in PROCEDURES}
    with pytest.MonkeyPatch.context() as patch:
        for name, recorder in recorders.items():
            patch.setattr(_core, name, recorder)
        public_calls(tmp_path_factory.mktemp("alone"))
    return {name: recorder.calls for name, recorder in recorders.items()}


def replayed(procedure, calls):
    """The bits of the results, and of the arguments that are changed in place."""
    answers = []
    for args, options in calls:
        own = [np.copy(arg, order="A") if isinstance(arg, np.ndarray) else arg for arg in args]
        found = procedure(*own, **options)
        parts = found if isinstance(found, tuple) else (found,)
        answers += [
            np.asarray(part).tobytes() for part in (*parts, *own) if not isinstance(part, str)
        ]
    return answers


def test_every_procedure_is_called(recorded):
    """Every procedure, including a new one, has a call here."""
    assert {name for name, calls in recorded.items() if not calls} <= FILES


@pytest.mark.slow
def test_all_procedures_at_once(recorded):
    """Each thread starts with a different procedure, and several threads call each procedure at a time."""
    names = sorted(PROCEDURES - HANDLES - FILES)
    alone = {name: replayed(getattr(_core, name), recorded[name]) for name in names}

    def work(i):
        order = [names[(i * len(names) // THREADS + j) % len(names)] for j in range(len(names))]
        return [
            name for _ in range(ROUNDS) for name in order
            if replayed(getattr(_core, name), recorded[name]) != alone[name]
        ]  # fmt: skip

    assert not [name for found in together(work) for name in found]


def test_one_procedure_at_once(recorded):
    """All threads call the same procedure at the same time."""
    for name in sorted(PROCEDURES - HANDLES - FILES):

        def work(_, name=name):
            return replayed(getattr(_core, name), recorded[name])

        alone = work(0)
        assert all(found == alone for found in together(work)), name


def test_results_at_once(tmp_path):
    """Threads that compute, fill, describe, write and free results get the files of one thread."""
    alone = saved(tmp_path / "alone")
    assert all(found == alone for found in together(lambda i: saved(tmp_path / str(i))))
