"""Limits of a computation: events, memory, stack, threads, and forked processes."""

import math
import os
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters

#: Without load a light primary mass between the walls of a heavy, elastic one bounces faster and faster: the time
#: between impacts has no practical lower bound, and four load cycles have billions of impacts.
FAST = vi.Oscillator(xi=0.0114, mu=1e6, restitution=1)
RIG = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
EVENT_LIMIT = 13


def child(code, seconds=60, environment=None):
    """Run a script in a separate process with a time limit."""
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], timeout=seconds, capture_output=True, text=True,
        check=False, env=os.environ | (environment or {}),
    )  # fmt: skip


def assert_answers(done, wanted):
    assert (done.returncode, done.stdout.split()) == (0, wanted.split()), done.stderr[-2000:]


# events


def test_basins_end():
    """States whose simulation has too many events are undecided, and are counted as such."""
    found = vi.basins(
        FAST, 0.5, 37.0, states=3, cycles=4, probes=1, max_cycles=2, load=0, max_events=20_000
    )
    assert found.labels.tolist() == [-3, -3, -3]
    assert not found.attractors
    assert "3 not decided" in repr(found)
    assert any("max_events was reached" in text for _, text in found._result.notes)


def test_response_ends():
    """A frequency ratio with too many events has a status that says so, and no amplitude."""
    found = vi.response(FAST, [0.5, 0.6], 37.0, states=2, settling=5, keep=3, max_events=1000)
    ended = found.status == EVENT_LIMIT
    assert ended.any()
    assert np.isnan(found.attenuation[ended]).all()
    assert "max_events" in vi.status_text(EVENT_LIMIT)


@pytest.mark.parametrize("r", [[0.5, 1.0], [1.0, 0.5]])
def test_nothing_is_left_of_the_simulation_before(r):
    """Where a simulation has too many events, no number of the previous one in the thread is shown."""
    found = vi.response(RIG, r, 20.0, states=2, settling=50, keep=9, max_events=150, threads=1)
    assert sorted(found.status.ravel().tolist()) == [0, 0, EVENT_LIMIT, EVENT_LIMIT]
    ended = found.status == EVENT_LIMIT
    for values in (found.cycles, found.symbols, found.impacts, found.rests):
        assert not values[ended].any()
    assert found.impacts[~ended].all()
    failed = ended.all(axis=1)
    assert failed.sum() == 1
    for values in (found.lowest, found.highest):
        np.testing.assert_array_equal(np.isnan(values), failed)
    assert f"from {np.nanmin(found.attenuation):.4g} to" in repr(found)


def test_sweeps_end():
    """A value at which a simulation had too many events has a status that says so."""
    found = vi.bifurcation_diagram(
        FAST, "r", [0.5, 0.6, 0.7], clearance=37.0, settling=5, keep=3, load=0, max_events=10_000
    )
    status = found._result.tables["cells"].columns["status"].values
    assert (status == EVENT_LIMIT).any()


def test_exponents_end():
    """A single point whose trajectory has too many events is an error that names the limit."""
    with pytest.raises(vi.errors.VibroimpactError, match="max_events"):
        vi.lyapunov(RIG, 1.04, 20.0, cycles=1000, discard=10, max_events=100)


def test_search_ends():
    """A state whose simulation has too many events is counted as unfinished, and leads to no motion."""
    found = vi.find(
        FAST, 0.5, 37.0, max_impacts=2, max_cycles=1, guesses=0, releases=0, states=4, settling=4,
        max_events=1000,
    )  # fmt: skip
    assert found.search.unfinished == found.search.states == 4
    assert "max_events" in found.search.text


def test_decay_ends():
    """A free vibration with too many impacts is cut short, and its result is marked."""
    found = vi.decay(FAST, 1e-3, z_dot=1.0, cycles=3, max_events=1000)
    assert found._result.tables["runs"].columns["status"].values.tolist() == [EVENT_LIMIT]


def test_survey_ends():
    """A point of a survey whose simulation has too many events is counted as such."""
    found = vi.atlas(
        RIG,
        (1.03, 1.05),
        (20, 30),
        max_impacts=2,
        survey=3,
        settling=40,
        lines=5,
        guesses=0,
        max_events=20,
    )
    assert found.counts["event limit reached"] == 3


@pytest.mark.parametrize(
    "study", ["basins", "response", "bifurcation", "lyapunov", "find", "decay"]
)
def test_stop_within_a_cycle(study):
    """A stop request ends a study within a load cycle, even if the cycle has millions of impacts."""
    groups = {
        "basins": "states = 3, cycles = 4, probes = 1, max_cycles = 2, load = 0",
        "response": "r_min = .5, r_max = .6, r_points = 2, states = 1, settling = 1",
        "bifurcation": "parameter = 'mu', low = 1e5, high = 1e6, values = 2, load = 0, settling = 9",
        "lyapunov": "load = 0, x_dot = 1, z_dot = 20",
        "find": "max_impacts = 2, max_cycles = 1, guesses = 0, states = 3, load = 0",
        "decay": "z_dot = 1",
    }  # fmt: skip
    r = "" if study in ("response", "decay") else "r = .5"
    text = (
        f"&system xi = .0114, mu = 1e6, restitution = 1, {r} /\n&{study} "
        f"clearance = {1e-6 if study == 'decay' else 37}, max_events = 1000000000, {groups[study]} /\n"
    )
    counters = new_counters()
    answer = []
    worker = threading.Thread(
        target=lambda: answer.append(
            _core.run_case(np.frombuffer(text.encode(), "S1"), 1, counters)
        ),
        daemon=True,
    )
    worker.start()
    time.sleep(0.3)
    counters[2] = 1
    begin = time.monotonic()
    worker.join(20)
    assert answer, f"{study} did not stop"
    assert time.monotonic() - begin < 10
    _core.free_result(answer[0][0])


def test_largest_number_of_events():
    """A trajectory stores its events, so max_events is bounded."""
    with pytest.raises(vi.errors.ParameterError, match="50000000"):
        vi.simulate(RIG, 1.04, 20.0, 1e9, max_events=10**9)


@pytest.mark.parametrize("batches", [2**31 - 1, 2**31, 2**30, 1001])
def test_batches(batches):
    """The number of batches is checked before it is doubled, so that it cannot overflow."""
    with pytest.raises(vi.errors.ParameterError, match="1000"):
        vi.lyapunov(RIG, 1.04, 20.0, batches=batches)


# damping


@pytest.mark.parametrize("xi", [5e-324, 1e-310, 1e-160, 1e-30, 1e-13])
def test_hardly_any_damping_at_resonance(xi):
    """At r = 1 with a tiny xi vibrations of amplitude 1/(2 xi) lose all digits: refused, as for xi = 0."""
    osc = vi.Oscillator(xi=xi, mu=0.028, restitution=0.75)
    pattern = vi.Pattern("RL")
    for call in (
        lambda: vi.simulate(osc, 1.0, 25.0, 5),
        lambda: vi.simulate_bundle(osc, [0.9, 1.0], 25.0, 5),
        lambda: vi.response(osc, [0.9, 1.0, 1.1], 25.0),
        lambda: vi.response(osc, [0.9, 1.0, 1.2], 25.0),
        lambda: vi.exact(osc, 1.0, 25.0, ([0, 3.0], pattern)),
        lambda: vi.equispaced(osc, 1.0, 25.0),
        lambda: vi.periodic(osc, 1.0, [0, 3.0], pattern),
        lambda: vi.find(osc, 1.0, 25.0),
        lambda: vi.basins(osc, 1.0, 25.0, states=3),
        lambda: vi.lyapunov(osc, 1.0, 25.0),
        lambda: vi.lyapunov(osc, [0.9, 1.0, 1.2], 25.0),
        lambda: vi.bifurcation_diagram(osc, "r", [0.9, 1.0, 1.1], clearance=25.0),
        lambda: vi.bifurcation_diagram(osc, "r", [0.9, 1.0, 1.2], clearance=25.0),
        lambda: vi.bifurcation_diagram(osc, "xi", [xi, 0.1, 0.3], r=1.0, clearance=25.0),
        lambda: vi.zone(osc, pattern, (0.9, 1.1), (20, 30)),
        lambda: vi.atlas(osc, (0.9, 1.1), (20, 30)),
        lambda: vi.branch(vi.equispaced(osc, 1.04, 25.0)[0], "r", (0.95, 1.05)),
        lambda: vi.branch(vi.equispaced(RIG, 1.0, 25.0)[0], "xi", (xi, 0.1)),
    ):
        with pytest.raises(vi.errors.ParameterError, match="resonance"):
            call()
    chart = vi.chart(osc, pattern, r=[0.9, 1.0, 1.1], clearance=[20.0, 30.0])
    assert (chart.status.sel(r=1.0) != 0).all()  # in a chart the column gets a status


# memory

#: Limits the address space to a little above what is used; {room} in MB.
LIMITED = """
import resource, numpy as np, vibroimpact as vi
osc = vi.Oscillator(xi=.0114, mu=.028, restitution=.75)
vi.simulate(osc, 1.04, 20., 1)
vi.response(osc, [1., 1.1], 25., states=1, settling=0, keep=3)
used = int(open("/proc/self/statm").read().split()[0])*resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, 2*(used + {room}*2**20,))
try:
    {call}
except MemoryError as error:
    print("raised", isinstance(error, vi.errors.OutOfMemoryError) or "numpy" in type(error).__module__)
print("alive")
"""
linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc, sets limits of Linux")


@linux
@pytest.mark.parametrize(
    "call",
    [
        "vi.response(osc, np.linspace(.8, 1.2, 900000), clearance=25., states=1, settling=0, keep=3)",
        "vi.bifurcation_diagram(osc, 'r', np.linspace(.8, 1.2, 60000), clearance=25., settling=0, keep=3)",
        "vi.basins(osc, 1.04, 20., states=5000000, cycles=1, probes=1, max_cycles=1)",
        "vi.basins(osc, 1.04, 20., (('x', -1, 1, 3000), ('y', -1, 1, 3000)), cycles=1, probes=1)",
        "vi.lyapunov(osc, np.linspace(.8, 1.2, 900000), 25., cycles=4, discard=0, batches=2)",
        "vi.decay(osc, .5, cycles=1000000, amplitude=1e9)",
        "vi.chart(osc, vi.Pattern('RL'), r=np.linspace(.8, 1.2, 900), clearance=np.linspace(20, 30, 900))",
        "vi.find(osc, 1.04, 20., max_impacts=2, max_cycles=1, states=1000000, settling=0)",
        "vi.atlas(osc, (1., 1.1), (20., 30.), survey=1000000, settling=1)",
        "vi.simulate(osc, 1.04, 2., 1e9, max_events=50000000)",
        "vi.zone(osc, vi.Pattern('RL' * 12), (1., 1.1), (20., 30.), max_points=200000, guesses=0, lines=5)",
        "vi.branch(vi.equispaced(osc, 1.04, 20.)[0], 'clearance', (19., 21.), max_points=100000)",
    ],
    ids=lambda call: call.split("(")[0][3:],
)
def test_memory(call):
    """A case that needs more memory than is available raises MemoryError, and the interpreter continues."""
    assert_answers(child(LIMITED.format(room=250, call=call), 120), "raised True alive")


@linux
def test_memory_of_a_small_case():
    """A case that fits in the memory is computed."""
    call = (
        "print(vi.response(osc, np.linspace(.8, 1.2, 9), 25., states=2, settling=5, keep=3).r.size)"
    )
    assert_answers(child(LIMITED.format(room=250, call=call)), "9 alive")


# forks

FORKED = """
import os, sys, numpy as np, vibroimpact as vi
osc = vi.Oscillator(xi=.0114, mu=.028, restitution=.75)
phases = np.vstack([np.zeros(4096), np.linspace(2, 4, 4096)])
calls = dict(
    flags=lambda: vi.stability_flags(osc, 1.04, phases, vi.Pattern("RL"), threads=2).stable.sum(),
    bundle=lambda: vi.simulate_bundle(osc, np.linspace(1.03, 1.05, 8), 25., 30, threads=2).x.sum(),
    big=lambda: vi.simulate_bundle(osc, np.linspace(1.03, 1.05, 8), 25., 900, threads=2).x.sum(),
    chart=lambda: vi.chart(osc, vi.Pattern("RL"), r=np.linspace(1., 1.1, 5), clearance=np.linspace(20, 30, 5),
                           threads=2)["found"].values.sum(),
    response=lambda: vi.response(osc, np.linspace(1., 1.1, 5), 25., states=2, settling=5, threads=2).highest.sum(),
)
before = {name: call() for name, call in calls.items()}
pid = os.fork()
if pid == 0:
    same = all(call() == before[name] for name, call in calls.items())
    os._exit(0 if same else 3)
print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
print(all(call() == before[name] for name, call in calls.items()))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_fork():
    """A child forked after threaded calls computes the same as its parent, and does not wait for lost threads."""
    assert_answers(child(FORKED, 120), "0 True")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_fork_from_another_thread():
    """A child forked by a thread other than the main one computes the same."""
    code = FORKED.replace("\n", "\n    ")
    code = f"import threading\ndef work():\n    {code}\nt = threading.Thread(target=work)\nt.start()\nt.join(90)\n"
    assert_answers(child(code, 120), "0 True")


# a stop request during a load cycle of a million oscillations

SLOW = {
    "simulate": "vi.simulate(rig, 1e-6, .5, 100000, progress=stop)",
    "bifurcation": "vi.bifurcation_diagram(rig, 'clearance', [.5, .6], r=1e-6, progress=stop)",
    "response": "vi.response(rig, [1e-6, 2e-6], clearance=.5, states=20, progress=stop)",
    "find": "vi.find(rig, 1e-6, .5, progress=stop)",
    "chart": "vi.chart(rig, 'RL', r=np.linspace(1e-6, 2e-6, 90), clearance=np.linspace(.1, 3, 90), progress=stop)",
    "zone": "vi.zone(rig, 'RL*', (1e-6, 2e-6), (.1, 3), progress=stop)",
    "lyapunov": "vi.lyapunov(rig, 1e-6, [.5, .6], cycles=100000, progress=stop)",
    "basins": "vi.basins(rig, 1e-6, .5, states=30, progress=stop)",
}
STOPPED = """
import time, numpy as np, vibroimpact as vi
rig = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
deadline = time.monotonic() + 1

def stop(*_):
    if time.monotonic() > deadline:
        raise TimeoutError

try:
    {}
    print("finished")
except TimeoutError:
    begin = time.process_time()
    while True:
        now = time.process_time()
        time.sleep(0.3)
        if time.process_time() - now < 0.1:
            break
    print(time.process_time() - begin)
"""


@pytest.mark.parametrize("study", SLOW)
def test_stop_within_a_load_cycle(study):
    """An abandoned call of the core stops within a fraction of a second, however long a load cycle is."""
    done = child(STOPPED.format(SLOW[study]), 120)
    assert done.returncode == 0, done.stderr[-2000:]
    assert float(done.stdout) < 1.5


def test_slow_load():
    """A rest during half a million oscillations takes few steps, and ends where the force on the wall ends.

    Both masses follow the load in their steady motion Im(H exp(i r t)); the contact force is proportional to it.
    """
    r = 1e-6
    response = 1 / (1 - (1 + RIG.mu) * r**2 + 2j * RIG.xi * r)
    x = (response * np.exp(1j)).imag
    x_dot = (1j * r * response * np.exp(1j)).imag
    begin = time.process_time()
    run = vi.simulate(
        RIG, r, 1.0, 1, {"t": 1 / r, "x": x, "x_dot": x_dot, "z": x + 0.5, "z_dot": x_dot}
    )
    assert time.process_time() - begin < 1
    release = run.events[0]
    assert (release["kind"], release["side"]) == ("release", "R")
    assert release["phase"] == pytest.approx(math.pi - np.angle(response), abs=1e-9)


# stacks and threads

STUDY = """
import vibroimpact as vi, numpy as np
osc = vi.Oscillator(xi=.005, mu=.042, restitution=.75)
try:
    print(vi.basins(osc, .94, 37., states=30, cycles=100, probes=5, threads=2).labels.size)
    print(vi.simulate_bundle(osc, [.9, .91], 37., 30, threads=2).x.size)
    print(vi.stability_flags(osc, .94, [[0, 0], [3, 4]], vi.Pattern("RL"), threads=2).stable.size)
except vi.errors.VibroimpactError as error:
    print(error)
"""


@pytest.mark.parametrize("size", ["1k", "16k", "64k", "64 K", "16384B", "1M", "1000000000G", "x"])
def test_stacks_of_other_threads(size):
    """If OpenMP's threads would have small stacks, a single thread computes."""
    assert_answers(child(STUDY, environment={"OMP_STACKSIZE": size}), "30 2 2")


@pytest.mark.parametrize("threads", ["100000", "1"])
def test_number_of_threads(threads):
    """The number of threads from the environment is limited to the number of processors."""
    assert_answers(child(STUDY, environment={"OMP_NUM_THREADS": threads}), "30 2 2")


@linux
@pytest.mark.parametrize("size", [256, 128])
def test_small_stack_of_the_process(size):
    """If the stack of the process is small, a study runs on a separate, larger one."""
    limit = f"resource.setrlimit(resource.RLIMIT_STACK, ({size * 1024}, {size * 1024}))"
    assert_answers(child(f"import resource, vibroimpact\n{limit}\n{STUDY}"), "30 2 2")


@linux
def test_small_stack_of_a_thread():
    """A study called in a thread with a small stack runs, or its error says why not; the process continues."""
    code = f"import threading\nthreading.stack_size(65536)\ndef work():\n{textwrap.indent(STUDY, '    ')}\n"
    done = child(
        code
        + "import vibroimpact\nt = threading.Thread(target=work)\nt.start()\nt.join()\nprint('alive')\n"
    )
    assert done.returncode == 0, done.stderr[-1000:]
    assert "alive" in done.stdout
    assert "30" in done.stdout or "stack of this thread is too small" in done.stdout


#: Calls of the core with arrays, also for long motions and structures with many coordinates.
CALLS = """
import sys, threading
import numpy as np, vibroimpact as vi

rig = vi.Oscillator(xi=.0114, mu=.028, restitution=(.75, .61))
even = vi.Oscillator(xi=.005, mu=.042, restitution=.75)
pair, column = vi.Pattern("RL"), [0, 4.3417]
motion = vi.exact(even, .94, 37., (column, pair))
long = vi.Pattern("RL" * 40, cycles=40)
phases = np.add.outer(2*np.pi*np.arange(40), column).ravel()
run = vi.simulate(rig, .9, 6., 4, discard=300)
flip = vi.branch(motion, parameter="clearance", bounds=(34, 38)).special_points[1]
wall, drive = vi.Structure([1], [.1], [1], [vi.Gap([1], 1, .8)]), vi.Load(1., cosine=[1])
springs = 2*np.eye(30) - np.eye(30, k=1) - np.eye(30, k=-1)
chain = vi.Structure([1.]*30, .02*springs, springs, [vi.Gap(np.eye(30)[-1], 1., .7)])
shaken = vi.Load(.9, sine=[1.]*30)
calls = [
    lambda: vi.periodic(even, .94, phases, long).X,
    lambda: vi.periodic_batch(even, [.9, .94], np.transpose([column, column]), pair).clearance,
    lambda: vi.stability_flags(even, [.9, .94], np.transpose([column, column]), pair).stable,
    lambda: vi.equispaced(even, .94, 20.)[0].X,
    lambda: vi.linear_system(even, .94, phases, long)[0],
    lambda: motion.impact_maps(),
    lambda: motion.sample([0., 1.]).X,
    lambda: vi.exact(even, .94, 37., (phases, long)).X,
    lambda: vi.exact(rig, .9, 6., run).X,
    lambda: vi.simulate(rig, .9, 6., 4, discard=300).events["x"],
    lambda: run.sample([run.initial_state["t"]]).X,
    lambda: run.period().events["x"],
    lambda: vi.simulate_bundle(even, [.9, .91], 37., 30).x,
    lambda: vi.same_motion(motion, motion),
    lambda: vi.standard_motion(motion).X,
    lambda: flip.switch()[0].X,
    lambda: vi.simulate(chain, shaken, cycles=5).sample([0., 1.])[0],
    lambda: vi.periodic(chain, shaken, [2.], [0]).multipliers,
    lambda: vi.exact(wall, drive, ([.1], [0])).matrix,
    lambda: vi.exact(wall, drive, vi.simulate(wall, drive, cycles=40)).matrix,
]
wanted = [call() for call in calls]
threading.stack_size(65536)
answers = []
for call in calls:
    thread = threading.Thread(target=lambda: answers.append(call()))
    thread.start()
    thread.join()
print(len(answers), all(map(np.array_equal, wanted, answers)))
"""


@linux
def test_calls_in_threads_with_small_stacks():
    """Calls with arrays give the same bits in threads with the smallest stack that Python allows."""
    assert_answers(child(CALLS), "20 True")


#: Threads with a small stack start workers at the same time; then a child is forked while a worker is started.
STARTS = """
import os, threading, vibroimpact as vi
from vibroimpact.base.interrupt import _Worker

even = vi.Oscillator(xi=.005, mu=.042, restitution=.75)
def call():
    return vi.exact(even, .94, 37., ([0, 4.3417], "RL")).X.tobytes()
wanted = call()
def size_left():
    ready = threading.Barrier(9)
    def work():
        ready.wait()
        ready.wait()
        _Worker()
    threading.stack_size(0)
    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    ready.wait()
    threading.stack_size(65536)
    ready.wait()
    for thread in threads:
        thread.join()
    return threading.stack_size()
print({size_left() for _ in range(20)} == {65536})

with _Worker.starting:
    pid = os.fork()
    if pid == 0:
        thread = threading.Thread(target=lambda: os._exit(0 if call() == wanted else 3), daemon=True)
        thread.start()
        thread.join(20)
        os._exit(4)
print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
"""


@linux
def test_threads_with_small_stacks_at_once():
    """Threads that start workers at the same time keep the stack size that was set; a forked child computes."""
    assert_answers(child(STARTS), "True 0")


def test_exponents_of_nothing_are_not_read():
    """The status codes used in this file are those of the core, and a plain simulation works."""
    assert [vi.status_text(code) for code in (EVENT_LIMIT, EVENT_LIMIT + 1)] == [
        "the simulation reached max_events events before its end", "out of memory",
    ]  # fmt: skip
    assert math.isfinite(vi.simulate(RIG, 1.0, 25.0, 5).final_state["x"])
