"""Runs miss no switch: grazing contacts, two crossings within a step, and rest at y = 0.

A switch is a separation (y rises through 0) or a landing (y falls through 0). Near the switch, y
reaches an extremum at a small height above or depth below 0.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from fivtui import Parameters, simulate, simulate_batch
from fivtui.model import System
from fivtui.model.slider_belt import State
from fivtui.taylor.stepper import TaylorStepper
from fivtui.transient.request import KernelChoice

# Distances from the switch at y = 0 at which the motion turns round, m.
DEPTHS = [10.0**-n for n in range(2, 13)]
TOLERANCES = (1e-12, 1e-6)


class ContactRecord(NamedTuple):
    """Separations, landings and final vertical state of a run, whichever method computed it.

    Times in s; `first` is that of the first switch, NaN without a switch.
    """

    separations: int
    reattachments: int
    separated_time: float
    first: float
    y: float
    vy: float


RunMethod = Callable[[Sequence[Parameters], Sequence[State], float, float], list[ContactRecord]]


def run_singly(kernel: KernelChoice) -> RunMethod:
    def run(
        sets: Sequence[Parameters], starts: Sequence[State], t_end: float, tol: float
    ) -> list[ContactRecord]:
        records = []
        for p, start in zip(sets, starts, strict=True):
            result = simulate(p, start=start, t_end=t_end, tol=tol, kernel=kernel)
            events = result.events
            records.append(
                ContactRecord(
                    separations=events.separations,
                    reattachments=events.reattachments,
                    separated_time=events.separated_time,
                    first=math.nan if events.first is None else events.first,
                    y=result.final.y,
                    vy=result.final.vy,
                )
            )
        return records

    return run


def run_as_batch(
    sets: Sequence[Parameters], starts: Sequence[State], t_end: float, tol: float
) -> list[ContactRecord]:
    table = np.array([p.values() for p in sets])
    batch = simulate_batch(table, start=np.array(starts), t_end=t_end, tol=tol)
    assert batch.failed.size == 0
    events = batch.events
    _, _, y, vy = batch.final.T
    columns = (events.separations, events.reattachments, events.separated_time, events.first, y, vy)
    return [
        ContactRecord(*row) for row in zip(*(column.tolist() for column in columns), strict=True)
    ]


RUN_METHODS: dict[str, RunMethod] = {
    "interpreted": run_singly("interpreted"),
    "compiled": run_singly("compiled"),
    "batch": run_as_batch,
}
each_run_method = pytest.mark.parametrize("integrate", RUN_METHODS.values(), ids=RUN_METHODS)
each_tolerance = pytest.mark.parametrize("tol", TOLERANCES)


# An undamped slider without coupling: y is a sine in contact and a parabola off the belt.
UNCOUPLED = Parameters(m=1.0, k2=4.0, k3=0.0, c1=0.0, c2=0.0, F=8.0, k_nl=0.0, mu=0.7)
# Angular frequency √(k2/m) of y in contact, rad/s, and depth F/k2 of the equilibrium, m.
OMEGA, REST_DEPTH = 2.0, 2.0


def start_rising_to(height: float, lead: float) -> State:
    """A start from which y rises to its only maximum, `height`, in the time `lead`."""
    amplitude = REST_DEPTH + height
    return (
        0.0,
        0.0,
        -REST_DEPTH + amplitude * math.cos(OMEGA * lead),
        amplitude * OMEGA * math.sin(OMEGA * lead),
    )


# Times from the start to the extremum, s.
LEADS = np.linspace(0.02, 1.4, 9).tolist()


@each_run_method
@each_tolerance
def test_a_contact_that_nearly_opens_stays_closed(integrate: RunMethod, tol: float) -> None:
    # A contact of smaller depth may open, by errors of the motion.
    depths = DEPTHS[:2] if tol > 1e-9 else DEPTHS[:-1]
    cases = itertools.product(depths, LEADS)
    starts = [start_rising_to(-depth, lead) for depth, lead in cases]
    for motion in integrate([UNCOUPLED] * len(starts), starts, 1.6, tol):
        assert (motion.separations, motion.reattachments, motion.separated_time) == (0, 0, 0.0)


def starts_closed(height: float, lead: float) -> bool:
    """Whether the lead exceeds four times √height/2, the time in s from y = 0 to the crest."""
    return lead > 2.0 * math.sqrt(height)


@each_run_method
def test_a_contact_that_opens_slightly_separates_and_reattaches_once(integrate: RunMethod) -> None:
    cases = [case for case in itertools.product(DEPTHS, LEADS) if starts_closed(*case)]
    starts = [start_rising_to(height, lead) for height, lead in cases]
    motions = integrate([UNCOUPLED] * len(cases), starts, 1.6, 1e-12)
    for (height, lead), motion in zip(cases, motions, strict=True):
        # Speed at the switch, m/s, duration of the flight, s, and time of the separation, s.
        speed = OMEGA * math.sqrt(height * (2.0 * REST_DEPTH + height))
        flight = 2.0 * speed * UNCOUPLED.m / UNCOUPLED.F
        opening = lead - math.asin(speed / (OMEGA * (REST_DEPTH + height))) / OMEGA
        # Heights are accurate only to rounding.
        tolerance = 1e-10 + 2e-15 / height
        assert (motion.separations, motion.reattachments) == (1, 1)
        assert motion.separated_time == pytest.approx(flight, rel=tolerance)
        assert motion.first == pytest.approx(opening, abs=tolerance * flight + 1e-14)


@each_run_method
def test_a_crest_exactly_at_the_switch_causes_no_lasting_separation(integrate: RunMethod) -> None:
    starts = [start_rising_to(0.0, lead) for lead in LEADS]
    motions = integrate([UNCOUPLED] * len(LEADS), starts, 1.6, 1e-12)
    for lead, motion in zip(LEADS, motions, strict=True):
        assert motion.separations == motion.reattachments <= 1
        assert motion.separated_time < 1e-6
        expected_y = REST_DEPTH * (math.cos(OMEGA * (1.6 - lead)) - 1.0)
        assert motion.y == pytest.approx(expected_y, abs=1e-11)


# The preload pulls the slider off the belt; its slower mode of vibration swings y down to the belt.
LIFTED = Parameters(m=1.0, k1=3.0, k2=4.0, k3=4.0, c1=0.0, c2=0.0, F=-1.2, k_nl=50.0, mu=0.7)
# Stiffness of the coupling of x and y, N/m: the spring k3 at 45° acts along each with half of it.
H = 0.5 * LIFTED.k3
# Stiffness of x, N/m: that of k1 and of the coupling.
A = LIFTED.k1 + H
# Equilibrium of y off the belt, m.
LIFTED_REST_Y = -LIFTED.F / (H * LIFTED.k1 / A)


def start_falling_to(depth: float, lead: float) -> tuple[State, float]:
    """A start from which y falls to its first minimum, -`depth`, and the angular frequency of y."""
    squared_frequencies, shapes = np.linalg.eigh([[A, -H], [-H, H]])
    omega, (x_part, y_part) = math.sqrt(squared_frequencies[0]), shapes[:, 0]
    rest_x, amplitude = H * LIFTED_REST_Y / A, LIFTED_REST_Y + depth
    x_ratio = x_part / y_part
    cosine, slope = math.cos(omega * lead), -omega * math.sin(omega * lead)
    x_state = (rest_x - amplitude * x_ratio * cosine, amplitude * x_ratio * slope)
    y_state = (LIFTED_REST_Y - amplitude * cosine, amplitude * slope)
    return (*x_state, *y_state), omega


@each_run_method
def test_a_fall_that_ends_above_the_switch_does_not_land(integrate: RunMethod) -> None:
    cases = itertools.product(DEPTHS[:-1], LEADS)
    starts = [start_falling_to(-height, lead)[0] for height, lead in cases]
    for motion in integrate([LIFTED] * len(starts), starts, 3.0, 1e-12):
        assert (motion.separations, motion.reattachments) == (0, 0)
        assert motion.separated_time == pytest.approx(3.0, rel=1e-14)


@each_run_method
def test_a_fall_slightly_beyond_the_switch_lands_and_separates_once(integrate: RunMethod) -> None:
    # From y = 0 to the minimum it takes about √(2 depth), in s. With a lead of three times that the
    # slider starts off the belt.
    cases = [
        (depth, lead)
        for depth, lead in itertools.product(DEPTHS, LEADS)
        if lead > 3.0 * math.sqrt(2.0 * depth)
    ]
    starts_and_frequencies = [start_falling_to(depth, lead) for depth, lead in cases]
    motions = integrate(
        [LIFTED] * len(cases), [start for start, _ in starts_and_frequencies], 2.0, 1e-12
    )
    for (depth, lead), (_, omega), motion in zip(
        cases, starts_and_frequencies, motions, strict=True
    ):
        amplitude = LIFTED_REST_Y + depth
        speed = omega * math.sqrt(depth * (2.0 * LIFTED_REST_Y + depth))
        # Half the time in contact, from the landing to the minimum of y.
        half_contact = math.asin(speed / (omega * amplitude)) / omega
        tolerance = 1e-10 + 1e-14 / depth
        assert (motion.separations, motion.reattachments) == (1, 1)
        assert motion.first == pytest.approx(
            lead - half_contact, abs=tolerance * half_contact + 1e-14
        )
        # The half contact is that of the motion off the belt. The contact force changes it by a
        # fraction of the order of the depth.
        contact_time = 2.0 - motion.separated_time
        assert contact_time == pytest.approx(
            2.0 * half_contact, rel=tolerance + 10.0 * depth, abs=1e-14
        )


def test_all_run_methods_agree_whether_the_nonlinear_scene_separates() -> None:
    # The slider separates exactly if it would rise above y = 0 with separation ignored.
    p = Parameters(mu=0.3)
    t_end = 0.45

    def start(speed: float) -> State:
        return (0.3, 0.1, -0.7, speed)

    def height(speed: float) -> float:
        run = simulate(p, start=start(speed), t_end=t_end, separation=False, kernel="interpreted")
        return run.peak.y_max

    # The start speed at which y just reaches 0, and the derivative of the height by the speed.
    touching_speed = brentq(height, 1.0, 6.0, xtol=1e-15, rtol=1e-15)
    slope = (height(touching_speed + 1e-3) - height(touching_speed - 1e-3)) / 2e-3
    speeds = [touching_speed + sign * depth / slope for depth in DEPTHS for sign in (1.0, -1.0)]
    heights = [height(speed) for speed in speeds]
    starts = [start(speed) for speed in speeds]
    motions_by_method = [
        integrate([p] * len(starts), starts, t_end, 1e-12) for integrate in RUN_METHODS.values()
    ]
    for peak_height, *motions in zip(heights, *motions_by_method, strict=True):
        for contact_record in motions:
            assert contact_record.separations == (peak_height > 0.0)
            assert contact_record.reattachments == contact_record.separations
            tolerance = 1e-10 + 1e-14 / abs(peak_height)
            assert contact_record.separated_time == pytest.approx(
                motions[0].separated_time, rel=tolerance
            )
            assert contact_record.first == pytest.approx(motions[0].first, rel=1e-6, nan_ok=True)


@each_run_method
def test_separation_and_landing_within_one_step_are_found(integrate: RunMethod) -> None:
    # The test is of use only if steps span both crossings: count, with separation ignored, the
    # steps over the crest that begin and end in contact.
    spanning_steps = 0
    for lead in LEADS:
        height = 1e-4
        start = start_rising_to(height, lead)
        stepper = TaylorStepper(System(UNCOUPLED, separation=False), start)
        step_over_crest = stepper.advance()
        while step_over_crest.end <= lead:
            step_over_crest = stepper.advance()
        spanning_steps += step_over_crest.y[0] < 0.0 and step_over_crest.final[2] < 0.0
        if starts_closed(height, lead):
            motion = integrate([UNCOUPLED], [start], 1.6, 1e-12)[0]
            assert (motion.separations, motion.reattachments) == (1, 1)
    assert spanning_steps >= 6


@each_run_method
def test_rest_at_the_switch_lasts(integrate: RunMethod) -> None:
    motion = integrate([Parameters(F=0.0)], [(0.0, 0.0, 0.0, 0.0)], 100.0, 1e-12)[0]
    assert motion[:3] == (0, 0, 0.0)
    assert (motion.y, motion.vy) == (0.0, 0.0)


@each_run_method
def test_a_decay_towards_the_switch_finds_every_crossing(integrate: RunMethod) -> None:
    # F = 0: the equilibrium lies on the switch, and every half period crosses it.
    p = Parameters(F=0.0, c1=3.0, c2=3.0)
    motion = integrate([p], [(0.0, 0.0, 0.0, 1.0)], 60.0, 1e-12)[0]
    exact = RUN_METHODS["interpreted"]([p], [(0.0, 0.0, 0.0, 1.0)], 60.0, 1e-13)[0]
    assert motion.separations == exact.separations > 20
    assert motion.reattachments == exact.reattachments
    assert motion.separated_time == pytest.approx(exact.separated_time, rel=1e-9)
