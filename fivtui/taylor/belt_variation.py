"""Deviations from a motion on a belt of finite speed: slip both ways, stick, separation.

In slip with v = ±v_r and μ(v) = μ + Δ e, e = exp(−v/v_s), deviations obey

    m δẍ = (h ∓ μ(v) k_t) δy − a δx − (c1 − P Δ e/v_s) δẋ + m ẍ′
    m δÿ = −(k_t + h) δy + h δx − c2 δẏ + m ÿ′

with k_t = k2 + 3 k_nl y² and the explicit change ′ of both accelerations with the parameters. Where
the slider sticks, δẋ is the change of the belt's speed, whatever it was before: a deviation across
v_r = 0 is lost, exactly.
"""

from collections.abc import Callable, Mapping, Sequence
from operator import mul
from typing import Final

from fivtui.model.errors import ComputationError
from fivtui.model.modes import IN_CONTACT, MODES, Guard, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import State, accelerations, spring_force, tangent_stiffness

from .belt import OF_HOLD, OF_SPEED
from .friction import Law, decay, is_far, law_coefficients
from .segment import BeltSegment, Segment
from .series import Coefficients, coefficient_function, constants, right_hand_side, state_function
from .variation import ORDER, Deviations, Seed, Series, past_switch, product_of

_NOTHING: Final = [0.0] * (ORDER + 2)
_SIGNS: Final = {Mode.FORWARD: 1.0, Mode.BACKWARD: -1.0}


class BeltDeviations(Deviations):
    """Deviations from one motion on a belt of finite speed; as `Deviations`.

    A deviation of a start that sticks does not leave the belt: it has the change of its speed.
    """

    def __init__(self, p: Parameters, seeds: Sequence[Seed]) -> None:
        super().__init__(p, seeds)
        self._by = [seed.parameters for seed in seeds]
        self._smooth = p.mu_static == p.mu or p.speed_law is not None

    def advance(
        self, segment: Segment, end: float = 1.0, places: Sequence[float] = ()
    ) -> list[list[State]]:
        """Carry the deviations over the next segment, a `BeltSegment`: see `Deviations`."""
        if segment.mode is Mode.STICK:
            self._hold()
        found = super().advance(segment, end, places)
        if segment.switches and _guard(segment) in OF_SPEED:
            # At the switch itself the slider has the speed of the belt.
            for place, there in zip(places, found, strict=True):
                if place == 1.0:
                    there[:] = self._held(there)
        return found

    def _held(self, deviations: Sequence[State]) -> list[State]:
        return [
            (x, by.get("v_belt", 0.0), y, vy)
            for (x, _, y, vy), by in zip(deviations, self._by, strict=True)
        ]

    def _hold(self) -> None:
        self.now = self._held(self.now)

    def _series(
        self, mode: Mode, segment: Segment, since: float
    ) -> tuple[Coefficients, list[Series]]:
        p, duration = self._p, segment.duration
        x, vx, y, vy = state_function(len(segment.x) - 1)(segment.x, segment.y, since / duration)
        start = (x, vx / duration, y, vy / duration)
        field = _LinearField(p, mode, start)
        explicit = {name: field.by(name) for name in {name for by in self._by for name in by}}
        return (field.x, field.y), [
            field.deviation(one, _combined(by, explicit))
            for one, by in zip(self.now, self._by, strict=True)
        ]

    def _switch(self, segment: Segment) -> None:
        guard, then = _guard(segment), _after(segment)
        if then is Mode.STICK and guard in OF_SPEED:
            self._hold()
            return
        if guard in OF_HOLD and self._smooth:
            return
        p, state, mode = self._p, segment.final, segment.mode
        before, after = accelerations(p, state, mode), accelerations(p, state, then)
        jump = (0.0, after[0] - before[0], 0.0, after[1] - before[1])
        gradient = _gradient(p, state, guard)
        rates = (state[1], before[0], state[3], before[1])
        rate = sum(map(mul, gradient, rates))
        if rate == 0.0 and any(jump):
            raise ComputationError(
                f"at t = {segment.end:.9g} s the motion touches {guard.value} = 0 without crossing "
                "it: it has no derivatives there",
                "change the start or a parameter a little",
            )
        self.now = [
            past_switch(one, jump, gradient, _change(p, state, guard, by), rate)
            for one, by in zip(self.now, self._by, strict=True)
        ]


class _LinearField:
    # The linearised field along a piece of the motion, as series in time.

    def __init__(self, p: Parameters, mode: Mode, start: State) -> None:
        self._p, self._mode = p, mode
        self._sign = sign = _SIGNS.get(mode, 0.0)
        fall = p.mu_static - p.mu
        law = None
        if sign and p.v_s is not None:
            law = Law(sign, p.mu, fall, 1.0 / p.v_s)
            speed = max(sign * ((p.v_belt or 0.0) - start[1]), 0.0)
            law = None if is_far(law, speed) else law
        if law is None or fall == 0.0:
            expand = coefficient_function(right_hand_side(p, mode), ORDER)
            self.x, self.y = expand(*start, *constants(p, mode))
        else:
            self.x, self.y = law_coefficients(p, mode, law, start, ORDER)
        touching = mode in IN_CONTACT
        square = product_of(self.y, self.y) if touching and p.k_nl > 0.0 else _NOTHING
        self._cube = product_of(self.y, square) if touching else _NOTHING
        stiffness = [3.0 * p.k_nl * one for one in square]
        stiffness[0] += p.k2 if touching else 0.0
        self._touching = touching
        force = [-p.k2 * y - p.k_nl * r for y, r in zip(self.y, self._cube, strict=True)]
        self._force = force if touching else _NOTHING
        self._speed, self._e = _NOTHING, _NOTHING
        mu = [p.mu, *_NOTHING[1:]]
        damping = [-p.c1, *_NOTHING[1:]]
        self._push = [sign * one for one in self._force]
        if law is not None:
            self._speed = [-sign * (n + 1) * one for n, one in enumerate(self.x[1:])]
            self._speed[0] = speed
            self._speed.append(0.0)
            self._e = _decaying(self._speed, law.per_speed)
            mu = [one + fall * e for one, e in zip(mu, self._e, strict=True)]
            felt = product_of(self._force, self._e)
            damping = [one + fall * law.per_speed * e for one, e in zip(damping, felt, strict=True)]
            self._pushed = [sign * one for one in felt]
        else:
            self._pushed = _NOTHING
        h, m = 0.5 * p.k3, p.m
        coupling = [-sign * one / m for one in product_of(mu, stiffness)]
        coupling[0] += h / m
        self._mu = mu
        self._xy, self._xvx = coupling, [one / m for one in damping]
        self._yy = [-one / m for one in stiffness]
        self._yy[0] -= h / m

    def by(self, name: str) -> Series:
        """The explicit change of ẍ and ÿ with a parameter, as coefficients."""
        return _EXPLICIT[name](self)

    def deviation(self, start: State, given: Series) -> Series:
        """Taylor coefficients of a deviation."""
        p = self._p
        x, y = [start[0], start[1]], [start[2], start[3]]
        sticks = self._mode is Mode.STICK
        xx, yx, yvy = -(p.k1 + 0.5 * p.k3) / p.m, 0.5 * p.k3 / p.m, -p.c2 / p.m
        vx = [start[1]]
        bend = any(self._yy[1:])
        fading = any(self._xvx[1:])
        for n in range(ORDER):
            share = 1.0 / ((n + 1) * (n + 2))
            pull = sum(map(mul, self._yy[n::-1], y)) if bend else self._yy[0] * y[n]
            ay = pull + yx * x[n] + yvy * (n + 1) * y[n + 1] + given[1][n]
            if sticks:
                ax = 0.0
            else:
                pull = sum(map(mul, self._xy[n::-1], y)) if bend or fading else self._xy[0] * y[n]
                slow = sum(map(mul, self._xvx[n::-1], vx)) if fading else self._xvx[0] * vx[n]
                ax = pull + xx * x[n] + slow + given[0][n]
            x.append(ax * share)
            y.append(ay * share)
            vx.append((n + 2) * x[n + 2])
        return x, y

    def of_spring(self, change: Sequence[float]) -> Series:
        # What a change of P does.
        if not self._touching:
            return _NOTHING, _NOTHING
        m = self._p.m
        along = [self._sign * one / m for one in product_of(self._mu, change)]
        return along, [one / m for one in change]

    def of_friction(self, series: Sequence[float], factor: float = 1.0) -> Series:
        # Along x alone.
        return [factor / self._p.m * one for one in series], _NOTHING

    def of_mu(self) -> Series:
        # μ_s follows μ where it is not set.
        if self._p.mu_s is None:
            return self.of_friction(self._push)
        rest = [one - other for one, other in zip(self._push, self._pushed, strict=True)]
        return self.of_friction(rest)

    def of_belt_speed(self) -> Series:
        p = self._p
        if p.v_s is None or not self._sign:
            return _NOTHING, _NOTHING
        fall = p.mu_static - p.mu
        return self.of_friction(self._pushed, -self._sign * fall / p.v_s)

    def of_law_speed(self) -> Series:
        p = self._p
        if p.v_s is None:
            return _NOTHING, _NOTHING
        fall = (p.mu_static - p.mu) / (p.v_s * p.v_s)
        return self.of_friction(product_of(self._pushed, self._speed), fall)

    def of_mass(self) -> Series:
        m = self._p.m
        ax, ay = (
            [-(n + 1) * (n + 2) * one / m for n, one in enumerate(z[2:])] for z in (self.x, self.y)
        )
        return ax, ay

    def of_first_spring(self) -> Series:
        return [-one / self._p.m for one in self.x], _NOTHING

    def of_contact(self) -> Series:
        return self.of_spring([-one for one in self.y])

    def of_cubic_contact(self) -> Series:
        return self.of_spring([-one for one in self._cube])

    def of_preload(self) -> Series:
        return _NOTHING, [-1.0 / self._p.m, *_NOTHING[1:]]

    def of_static(self) -> Series:
        return self.of_friction(self._pushed)

    def of_first_damper(self) -> Series:
        return self._slowed(self.x), _NOTHING

    def of_second_damper(self) -> Series:
        return _NOTHING, self._slowed(self.y)

    def of_coupling(self) -> Series:
        half = 0.5 / self._p.m
        stretch = [half * (x - y) for x, y in zip(self.x, self.y, strict=True)]
        return [-one for one in stretch], stretch

    def _slowed(self, z: Sequence[float]) -> list[float]:
        m = self._p.m
        return [-(n + 1) * one / m for n, one in enumerate(z[1:])]


_EXPLICIT: Final[Mapping[str, Callable[[_LinearField], Series]]] = {
    "m": _LinearField.of_mass,
    "k1": _LinearField.of_first_spring,
    "k2": _LinearField.of_contact,
    "k3": _LinearField.of_coupling,
    "c1": _LinearField.of_first_damper,
    "c2": _LinearField.of_second_damper,
    "F": _LinearField.of_preload,
    "k_nl": _LinearField.of_cubic_contact,
    "mu": _LinearField.of_mu,
    "mu_s": _LinearField.of_static,
    "v_belt": _LinearField.of_belt_speed,
    "v_s": _LinearField.of_law_speed,
}


def _combined(by: Mapping[str, float], explicit: Mapping[str, Series]) -> Series:
    ax, ay = [0.0] * ORDER, [0.0] * ORDER
    for name, change in by.items():
        along, across = explicit[name]
        for n in range(ORDER):
            ax[n] += change * along[n]
            ay[n] += change * across[n]
    return ax, ay


def _decaying(speed: Sequence[float], per_speed: float) -> list[float]:
    # Coefficients of exp(−v/v_s).
    e = [decay(speed[0] * per_speed)]
    slope = [n * one * per_speed for n, one in enumerate(speed)]
    for n in range(1, len(speed)):
        e.append(-sum(map(mul, slope[1 : n + 1], e[::-1])) / n)
    return e


def _after(segment: Segment) -> Mode:
    assert isinstance(segment, BeltSegment)  # noqa: S101
    return segment.then


def _guard(segment: Segment) -> Guard:
    # That ended the segment.
    then = _after(segment)
    return next(end.guard for end in MODES[segment.mode].ends if then in end.to)


def _gradient(p: Parameters, state: State, guard: Guard) -> State:
    if guard is Guard.HEIGHT or guard is Guard.DEPTH:
        return (0.0, 0.0, 1.0 if guard is Guard.HEIGHT else -1.0, 0.0)
    if guard in OF_SPEED:
        return (0.0, -OF_SPEED[guard], 0.0, 0.0)
    sign, h = OF_HOLD[guard], 0.5 * p.k3
    return (
        sign * (p.k1 + h),
        0.0,
        -p.mu_static * tangent_stiffness(p, state[2]) - sign * h,
        0.0,
    )


def _change(p: Parameters, state: State, guard: Guard, by: Mapping[str, float]) -> float:
    # Of a guard with the parameters.
    x, _, y, _ = state
    if guard in OF_SPEED:
        return OF_SPEED[guard] * by.get("v_belt", 0.0)
    if guard not in OF_HOLD:
        return 0.0
    speed, dh = p.v_belt or 0.0, 0.5 * by.get("k3", 0.0)
    held = by.get("c1", 0.0) * speed + p.c1 * by.get("v_belt", 0.0)
    held += by.get("k1", 0.0) * x + dh * (x - y)
    static = by.get("mu" if p.mu_s is None else "mu_s", 0.0)
    softer = -by.get("k2", 0.0) * y - by.get("k_nl", 0.0) * y * y * y
    return static * spring_force(p, y) + p.mu_static * softer + OF_HOLD[guard] * held
