"""Limit cycles of smooth flows, known in closed form or in digits, by fivtui's continuation."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from fivtui.orbits.curves.arclength import PARAMETER, PERIOD, OrbitOnCurve
from fivtui.orbits.curves.branch_curve import BranchCurve
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray, MotionEnd
from fivtui.orbits.curves.following import CurvePart, Follower

Rate = Callable[[FloatArray, float], FloatArray]
# Turns a vector in the plane by a right angle.
RIGHT_ANGLE = np.array([[0.0, -1.0], [1.0, 0.0]])


class SmoothFlow:
    """A flow given by its rate of change and that rate's derivatives by state and parameter."""

    def __init__(self, state_count: int, rate: Rate, slopes: Rate) -> None:
        self.state_count, self._rate, self._slopes = state_count, rate, slopes

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> MotionEnd:
        n, value = self.state_count, float(values[0])

        def extended_rate(_t: float, z: FloatArray) -> FloatArray:
            # z has the state, then a row of derivatives for each of its variables: n by the start,
            # and one by the parameter.
            state, derivatives = z[:n], z[n:].reshape(n, n + 1)
            slopes = self._slopes(state, value)
            derivative_rates = slopes[:, :n] @ derivatives
            derivative_rates[:, n] += slopes[:, n]
            return np.concatenate([self._rate(state, value), derivative_rates.ravel()])

        start = np.concatenate([state, np.eye(n, n + 1).ravel()])
        run = solve_ivp(extended_rate, (0.0, time), start, method="DOP853", rtol=3e-12, atol=1e-12)
        final = run.y[:, -1]
        # Extremes of the first two variables, in the order of `MotionEnd`.
        extremes = np.array([run.y[:2].min(axis=1), run.y[:2].max(axis=1)]).T.ravel()
        return MotionEnd(
            final[:n], self._rate(final[:n], value), final[n:].reshape(n, n + 1), extremes
        )


def build_curve(flow: SmoothFlow, low: float, high: float) -> BranchCurve:
    # One for each variable of the state, the period and the parameter.
    units = np.ones(flow.state_count + 2)
    return BranchCurve(flow, units, (low, high), tests_touch=False)


def find_cycle(curve: BranchCurve, guess: list[float], normal: list[float]) -> OrbitOnCurve:
    """The cycle near a guess, in the plane through it with this normal.

    The second variable of the start is fixed: this determines the phase.
    """
    second_axis = np.eye(len(guess))[1]
    orbit = curve.orbits.solve(np.array(guess), np.array([second_axis, normal]))
    assert orbit is not None
    return orbit


def follow(
    curve: BranchCurve, start: OrbitOnCurve, max_points: int, *until: EventKind
) -> CurvePart[OrbitOnCurve]:
    return Follower(curve, min_size=1e-3, max_points=max_points).follow(start, until=until)


def van_der_pol() -> SmoothFlow:
    def rate(z: FloatArray, e: float) -> FloatArray:
        x, v = z
        return np.array([v, e * (1.0 - x * x) * v - x])

    def slopes(z: FloatArray, e: float) -> FloatArray:
        x, v = z
        acceleration_slopes = [-2.0 * e * x * v - 1.0, e * (1.0 - x * x), (1.0 - x * x) * v]
        return np.array([[0.0, 1.0, 0.0], acceleration_slopes])

    return SmoothFlow(2, rate, slopes)


def test_the_van_der_pol_cycle_has_its_known_period_and_amplitude() -> None:
    # At ε = 1: period 6.66328685932313, amplitude 2.00861986087484; series in ε of Andersen and
    # Geer (1982).
    curve = build_curve(van_der_pol(), -9.0, 11.0)
    start = find_cycle(curve, [2.0, 0.0, 2.0 * math.pi, 0.1], [0.0, 0.0, 0.0, 1.0])
    assert start.unknowns[0] == pytest.approx(2.0 + 0.1**2 / 96.0, abs=3e-7)
    series = 2.0 * math.pi * (1.0 + 0.1**2 / 16.0 - 5.0 * 0.1**4 / 3072.0)
    assert start.unknowns[PERIOD] == pytest.approx(series, abs=1e-8)
    part = follow(curve, start, 5)
    values = [float(point.unknowns[PARAMETER]) for point in part.points]
    assert values == sorted(values)
    assert values[-1] > 1.0
    first_beyond_one = next(point for point in part.points if point.unknowns[PARAMETER] > 1.0)
    period = float(first_beyond_one.unknowns[PERIOD])
    cycle_at_one = find_cycle(curve, [2.0, 0.0, period, 1.0], [0.0, 0.0, 0.0, 1.0])
    assert cycle_at_one.unknowns[PERIOD] == pytest.approx(6.66328685932313, abs=1e-10)
    assert cycle_at_one.unknowns[0] == pytest.approx(2.00861986087484, abs=1e-10)
    assert 0.0 < cycle_at_one.multipliers[0].real < 1.0


def duffing() -> SmoothFlow:
    # Cycles exist only at the damping 0, there of every size.
    def rate(z: FloatArray, damping: float) -> FloatArray:
        x, v = z
        return np.array([v, -x - x**3 + damping * v])

    def slopes(z: FloatArray, damping: float) -> FloatArray:
        x, v = z
        return np.array([[0.0, 1.0, 0.0], [-1.0 - 3.0 * x * x, damping, v]])

    return SmoothFlow(2, rate, slopes)


def test_cycles_of_the_duffing_oscillator_have_the_period_of_the_elliptic_integral() -> None:
    curve = build_curve(duffing(), -1.0, 1.0)
    start = find_cycle(
        curve, [0.2, 0.0, 2.0 * math.pi / math.sqrt(1.03), 0.0], [1.0, 0.0, 0.0, 0.0]
    )
    start = start if start.tangent[0] > 0.0 else start.reversed()
    part = follow(curve, start, 6)
    assert not part.events
    sizes = []
    for point in (start, *part.points):
        x, v, period, damping = point.unknowns.tolist()
        # The amplitude is the greatest x at the energy E = v²/2 + x²/2 + x⁴/4.
        energy = 0.5 * v * v + 0.5 * x * x + 0.25 * x**4
        square = -1.0 + math.sqrt(1.0 + 4.0 * energy)
        sizes.append(math.sqrt(square))
        exact = 4.0 * ellipk(0.5 * square / (1.0 + square)) / math.sqrt(1.0 + square)
        assert period == pytest.approx(exact, abs=1e-9)
        assert damping == pytest.approx(0.0, abs=1e-10)
        assert point.multipliers[0] == pytest.approx(1.0, abs=1e-8)
    assert sizes == sorted(sizes)
    assert sizes[-1] > 0.5


def bautin() -> SmoothFlow:
    # r' = r (μ + r² − r⁴), one turn in 2π: cycles at μ = r⁴ − r².
    def rate(z: FloatArray, mu: float) -> FloatArray:
        square = z @ z
        growth = float(mu + square - square * square)
        return np.asarray(growth * z + RIGHT_ANGLE @ z)

    def slopes(z: FloatArray, mu: float) -> FloatArray:
        square = z @ z
        growth = mu + square - square * square
        radial = growth * np.eye(2) + (2.0 - 4.0 * square) * np.outer(z, z)
        return np.column_stack([radial + RIGHT_ANGLE, z])

    return SmoothFlow(2, rate, slopes)


def test_a_fold_known_in_closed_form_is_located() -> None:
    curve = build_curve(bautin(), -10.0, 10.0)
    radius = 0.3
    start = find_cycle(
        curve, [radius, 0.0, 2.0 * math.pi, radius**4 - radius**2], [1.0, 0.0, 0.0, 0.0]
    )
    start = start if start.tangent[0] > 0.0 else start.reversed()
    part = follow(curve, start, 20, EventKind.FOLD)
    ((index, kind),) = part.events.items()
    assert kind is EventKind.FOLD
    assert part.points[index].unknowns[PARAMETER] == pytest.approx(-0.25, abs=1e-12)
    for point in part.points:
        square = float(point.unknowns[:2] @ point.unknowns[:2])
        assert point.unknowns[PARAMETER] == pytest.approx(square**2 - square, abs=1e-10)
        exponent = 2.0 * math.pi * 2.0 * square * (1.0 - 2.0 * square)
        assert point.multipliers[0].real == pytest.approx(math.exp(exponent), rel=1e-8)


@pytest.mark.parametrize(
    ("frequency", "kind"),
    [
        (0.3, EventKind.TORUS),
        pytest.param(0.5, EventKind.PERIOD_DOUBLING, marks=pytest.mark.whole),
    ],
)
def test_bifurcations_of_known_flows_are_located(frequency: float, kind: EventKind) -> None:
    # A circular cycle with a separate oscillation (a, b) that grows above λ = 0. For a torus its
    # multipliers are exp(2π (λ ± iω)), with the frequency ω.
    def rate(z: FloatArray, growth: float) -> FloatArray:
        x, y, a, b = z
        square = x * x + y * y
        if kind is EventKind.TORUS:
            oscillation = [growth * a - frequency * b, frequency * a + growth * b]
        else:
            # In a frame at half the angle of the circle the components grow at the rates λ and
            # λ − 1. The frame makes half a turn per turn of the circle: the multipliers are
            # −exp(2πλ) and −exp(2π (λ − 1)).
            cos, sin = x / math.sqrt(square), y / math.sqrt(square)
            reflection = np.array([[cos, sin], [sin, -cos]])
            matrix = (growth - 0.5) * np.eye(2) + 0.5 * reflection + 0.5 * RIGHT_ANGLE
            oscillation = (matrix @ (a, b)).tolist()
        return np.array([x * (1.0 - square) - y, y * (1.0 - square) + x, *oscillation])

    def slopes(z: FloatArray, growth: float) -> FloatArray:
        if kind is EventKind.TORUS:
            x, y, a, b = z
            oscillation = [[growth, -frequency, a], [frequency, growth, b]]
            radial = (1.0 - x * x - y * y) * np.eye(2) - 2.0 * np.outer(z[:2], z[:2])
            circle = radial + RIGHT_ANGLE
            return np.block([[circle, np.zeros((2, 3))], [np.zeros((2, 2)), np.array(oscillation)]])
        steps = 1e-6 * np.eye(5)
        arguments = np.append(z, growth)
        columns = [
            (
                rate((arguments + step)[:4], (arguments + step)[4])
                - rate((arguments - step)[:4], (arguments - step)[4])
            )
            / 2e-6
            for step in steps
        ]
        return np.array(columns).T

    curve = build_curve(SmoothFlow(4, rate, slopes), -5.0, 5.0)
    parameter_axis = [0.0] * 5 + [1.0]
    start = find_cycle(curve, [1.0, 0.0, 0.0, 0.0, 2.0 * math.pi, -0.05], parameter_axis)
    part = follow(curve, start, 2, kind)
    event_values = {
        event_kind: part.points[index].unknowns[PARAMETER]
        for index, event_kind in part.events.items()
    }
    assert event_values[kind] == pytest.approx(0.0, abs=1e-8)


def test_a_point_where_another_branch_crosses_is_located() -> None:
    # A circular cycle and a separate variable with z' = λ z − z³: other circles begin at λ = 0.
    def rate(z: FloatArray, growth: float) -> FloatArray:
        x, y, offset = z
        radial = 1.0 - x * x - y * y
        return np.array([x * radial - y, y * radial + x, growth * offset - offset**3])

    def slopes(z: FloatArray, growth: float) -> FloatArray:
        x, y, offset = z
        radial = (1.0 - x * x - y * y) * np.eye(2) - 2.0 * np.outer(z[:2], z[:2])
        jacobian = np.zeros((3, 4))
        jacobian[:2, :2] = radial + RIGHT_ANGLE
        jacobian[2, 2:] = growth - 3.0 * offset * offset, offset
        return jacobian

    curve = build_curve(SmoothFlow(3, rate, slopes), -5.0, 5.0)
    start = find_cycle(curve, [1.0, 0.0, 0.0, 2.0 * math.pi, -0.05], [0.0] * 4 + [1.0])
    part = follow(curve, start, 2, EventKind.BRANCH)
    assert list(part.events.values()) == [EventKind.BRANCH]
    assert part.points[-1].unknowns[PARAMETER] == pytest.approx(0.0, abs=1e-8)
