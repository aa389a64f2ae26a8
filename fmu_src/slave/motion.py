"""The motion at communication points: Taylor steps that outlive them, inputs that may change.

A Taylor step covers many communication steps. Its polynomial is kept until it is used up or an
input changes, so the result does not depend on where the communication points lie.
"""

from typing import NamedTuple

from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import Mode, State, accelerations, contact_force, mode_of
from fivtui.taylor.segment import Segment
from fivtui.taylor.stepper import Instant, TaylorStepper, local_tolerance


class Moment(NamedTuple):
    """The motion at a communication point: all that moving on changes, never changed itself.

    Attributes
    ----------
    t : float
        Time, s.
    state : State
        (x, ẋ, y, ẏ), m and m/s.
    mode : Mode
        Contact or separated.
    F, mu : float
        Preload, N, and friction coefficient up to here.
    separations, reattachments : int
        Numbers of switches up to here, a switch at this very time included.
    last_event : float
        Time of the last of them, s; the start time as long as there is none.
    instant : Instant
        Where the integrator stands: at the end of `segment`.
    segment : Segment or None
        The piece of motion that holds `t`; None where the inputs have just changed.
    """

    t: float
    state: State
    mode: Mode
    F: float
    mu: float
    separations: int
    reattachments: int
    last_event: float
    instant: Instant
    segment: Segment | None


class Motion:
    """A transient that is asked for time after time, under inputs held between those times.

    Parameters
    ----------
    p : Parameters
        The parameter set; its F and μ are the first inputs.
    state : State
        (x, ẋ, y, ẏ) at `t`, m and m/s.
    t : float
        Start time, s.
    separation : bool
        Whether separation is considered.
    tol : float
        Relative error to aim at after about a hundred periods.

    Attributes
    ----------
    moment : Moment
        Where the motion is.
    """

    def __init__(
        self, p: Parameters, state: State, *, t: float, separation: bool, tol: float
    ) -> None:
        self._p = p
        self._separation = separation
        self._tol = tol
        self._stepper = self._stepper_from(state, t)
        instant = self._stepper.instant
        self.moment = Moment(t, state, instant.mode, p.F, p.mu, 0, 0, t, instant, None)

    def state_at(self, t: float) -> State:
        """The state at a time, without moving on.

        Parameters
        ----------
        t : float
            Time, s; that of `moment`, or one between it and `known_until`.

        Returns
        -------
        State
            (x, ẋ, y, ẏ), m and m/s.
        """
        moment = self.moment
        if t == moment.t or moment.segment is None:
            return moment.state
        return moment.segment.state(t)

    def accelerations(self, state: State, *, F: float, mu: float) -> tuple[float, float]:
        """Accelerations (ẍ, ÿ), m/s², at a state in the present mode, under given inputs."""
        p = self._p
        if F != p.F or mu != p.mu:
            p = p.with_values({"F": F, "mu": mu})
        return accelerations(p, state, self.moment.mode)

    def contact_force(self, y: float) -> float:
        """Contact force P, N, at a vertical displacement, m, in the present mode."""
        return contact_force(self._p, y, self.moment.mode) + 0.0

    @property
    def known_until(self) -> float:
        """Time before which moving on under the same inputs computes no Taylor step, s."""
        segment = self.moment.segment
        return self.moment.t if segment is None else segment.end

    def move_to(self, t: float, *, F: float, mu: float) -> None:
        """Go on to a later time.

        Parameters
        ----------
        t : float
            Time, s; later than that of `moment`.
        F, mu : float
            Preload, N, and friction coefficient from here to `t`.

        Raises
        ------
        InputError
            If an input is out of range.
        ComputationError
            If the motion cannot be continued. It stays where it was, as with every exception.
        """
        begin = self.moment
        try:
            if F != begin.F or mu != begin.mu:
                self._change_inputs(F, mu)
            self._advance(t)
        except BaseException:
            self.restore(begin)
            raise

    def restore(self, moment: Moment) -> None:
        """Go to where a motion of the same problem was.

        Parameters
        ----------
        moment : Moment
            What follows is what followed then, to the last bit.
        """
        if moment.F != self._p.F or moment.mu != self._p.mu:
            self._p = self._p.with_values({"F": moment.F, "mu": moment.mu})
            self._stepper = self._stepper_from(moment.state, moment.t)
        self._stepper.resume(moment.instant)
        self.moment = moment

    def _stepper_from(self, state: State, t: float) -> TaylorStepper:
        return TaylorStepper(
            self._p, state, t=t, separation=self._separation, tol=local_tolerance(self._tol)
        )

    def _change_inputs(self, F: float, mu: float) -> None:
        at = self.moment
        p = self._p.with_values({"F": F, "mu": mu})
        state = at.state
        if self._separation and at.mode is not mode_of(p, state, separation=True):
            # The polynomial's y is on the wrong side by its rounding only: this is the switch.
            state = (state[0], state[1], 0.0, state[3])
        self._p = p
        self._stepper = self._stepper_from(state, at.t)
        instant = self._stepper.instant
        self.moment = _counted(at, instant.mode, at.t)._replace(
            state=state, F=F, mu=mu, instant=instant, segment=None
        )

    def _advance(self, t: float) -> None:
        moment, segment = self.moment, self.moment.segment
        state = None
        while segment is None or segment.end <= t:
            following = self._stepper.advance()
            if segment is not None:
                state = segment.final if segment.end == t else None
                moment = _counted(moment, following.mode, segment.end)
            segment = following
            moment = moment._replace(instant=self._stepper.instant, segment=segment)
        # Most communication steps come here at once; _replace would take as long as the rest.
        _, _, mode, F, mu, separations, reattachments, last_event, instant, _ = moment
        self.moment = Moment(
            t,
            segment.state(t) if state is None else state,
            mode,
            F,
            mu,
            separations,
            reattachments,
            last_event,
            instant,
            segment,
        )


def _counted(moment: Moment, mode: Mode, t: float) -> Moment:
    if mode is moment.mode:
        return moment
    separates = mode is Mode.SEPARATED
    return moment._replace(
        mode=mode,
        separations=moment.separations + separates,
        reattachments=moment.reattachments + (not separates),
        last_event=t,
    )
