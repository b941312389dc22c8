"""Random numbers: every function that uses them takes `rng`: a seed, a Generator or None."""

import inspect

import numpy as np
import pytest
import vibroimpact as vi
from shared_campaign import equispaced_case
from shared_systems import FIGURE6

GAPS = [vi.Gap([-1, 1], 10.0, 0.75), vi.Gap([1, -1], 10.0, 0.75)]
DAMPER = vi.Structure([1, 0.042], [0.01, 0], [1, 0], GAPS)
RIG = {
    "M": 2.7, "K": 42e3, "m": 0.11, "d": 0.006, "xi": 0.0114, "restitution": 0.7, "F0": 6.0, "frequency": 19.5,
}  # fmt: skip
UNCERTAIN = {"xi": (0.010, 0.012)}
#: Calls of each function, and the results that depend on random numbers.
CALLS = {
    "find": lambda rng: vi.find(
        DAMPER, vi.Load(0.94, sine=[1, 0]), 1, 1, guesses=1, states=3, settling=5, rng=rng
    ).case,
    "basins": lambda rng: vi.basins(
        FIGURE6, 1.04, 25.0, states=4, cycles=2, probes=1, rng=rng
    ).states.tolist(),
    "uncertainty": lambda rng: vi.uncertainty(
        FIGURE6, "RL", [1.0, 1.05], [20.0, 22.5, 25.0, 65.0, 69.0], UNCERTAIN | {"mu": (0.01, 0.05)}, samples=9,
        bands=False, rng=rng,
    ).probability.tolist(),
    "limit_probability": lambda rng: float(
        vi.limit_probability(
            FIGURE6, 1.04, 25.0, {"R1": (0.4, 0.9)}, {"attenuation": 0.5}, samples=25, settling=60, rng=rng
        ).probability
    ),
    "boundary_bands": lambda rng: [
        repr(band.sampled.tolist())
        for band in vi.boundary_bands(zone(), UNCERTAIN, samples=2, vertices=2, rng=rng)
    ],
    "virtual_record": lambda rng: vi.virtual_record(0.1, rng, **RIG).load.tolist(),
    "Sweep": lambda rng: vi.Sweep(
        equispaced_case(), {"r": (0.9, 1.1)}, samples=4, rng=rng
    ).points.tolist(),
}  # fmt: skip
ZONES = []


def zone():
    """The zone of the equispaced motions, traced once."""
    if not ZONES:
        ZONES.append(vi.zone(FIGURE6, "RL", (0.9, 1.1), (10, 100), symmetric=True, lines=5))
    return ZONES[0]


@pytest.mark.parametrize("name", CALLS)
def test_a_seed_a_generator_or_none(name):
    """A seed gives the same numbers in each call, and a generator the next ones; None gives different ones."""
    call = CALLS[name]
    one, two = (np.random.default_rng(5) for _ in range(2))
    first, second = call(one), call(one)
    assert (call(two), call(two)) == (first, second)
    assert call(3) == call(3) == call(np.int64(3))
    if name in ("basins", "virtual_record", "Sweep", "find"):
        assert (
            len({repr(call(rng)) for rng in (3, 4, None, None)} | {repr(first), repr(second)}) == 6
        )


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("wrong", [-1, 2**63, 1.5, "1", True, [1]])
def test_what_is_no_rng_is_refused(name, wrong):
    with pytest.raises(
        (vi.ParameterError, vi.ParameterTypeError), match=r"^rng = .*Generator or None"
    ):
        CALLS[name](wrong)


def test_the_seed_that_was_drawn_is_in_the_case():
    """A result with fresh random numbers is reproduced by its namelist."""
    result = vi.basins(FIGURE6, 1.04, 25.0, states=4, cycles=2, probes=1, rng=None)
    again = vi.basins(FIGURE6, 1.04, 25.0, states=4, cycles=2, probes=1, rng=result.keys["seed"])
    assert again.to_dict() == result.to_dict()


def test_the_design_takes_a_generator(short):
    """Both the search and its confirmation are reproduced; the keys keep the seed."""
    order = {
        "r": (1.0, 1.02), "free": {"clearance": (20, 45)}, "samples": 0, "evaluations": 8, "specimens": 1,
        "nodes": 2, "states": 1, "settling": 20, "keep": 2, "searches": 1,
    }  # fmt: skip
    seeds = [
        vi.design(FIGURE6, **order, rng=np.random.default_rng(5)).keys["seed"] for _ in range(2)
    ]
    found = vi.design(FIGURE6, **order, rng=3)
    assert (found.keys["seed"], seeds[0]) == (3, seeds[1])
    one, two = (found.confirm(10, rng=np.random.default_rng(6)) for _ in range(2))
    assert one.to_dict() == two.to_dict()


def test_one_name():
    """No public function or method has an argument `seed`."""
    for name in vi.__all__:
        thing = getattr(vi, name)
        parts = (
            [thing]
            if inspect.isfunction(thing)
            else [*vars(thing).values()]
            if inspect.isclass(thing)
            else []
        )
        for part in filter(inspect.isfunction, parts):
            assert "seed" not in inspect.signature(part).parameters, (name, part)
