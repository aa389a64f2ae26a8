"""Compare a run with a measurement: deviation, spectra and verdict."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import COLUMNS, Column, InputError, System, check_known, parse_number
from fivtui.results import Plottable, Table, TableResult
from fivtui.signals import Spectrum, motion_at, spectrum
from fivtui.transient import Transient

from .options import ValidateOptions
from .reading import Measurement, has_column_name, read_measurement
from .tolerances import Tolerances, read_tolerances

if TYPE_CHECKING:
    from fivtui.charts import Sheet

FloatArray = NDArray[np.float64]

# Columns of a trajectory that can be measured: displacements, velocities and the contact force P.
QUANTITIES: Final = ("y", "x", "vy", "vx", "P")
UNITS: Final = {column.name: column.unit for column in COLUMNS}
# Least number of measured samples within the run.
_MIN_SAMPLES: Final = 16
# Greatest number of points of the grid on which the shift is searched.
_MAX_GRID_POINTS: Final = 1 << 16
# Least Σ(x − mean)² of the run over a time as long as the signal, relative to the greatest: where
# the run rests, a correlation would come from rounding errors.
_LEAST_SQUARE_SUM: Final = 1e-12
_MIN_DIVISOR: Final = 1e-300
_NO_VERDICT: Final = "none: give --band, --frequency or --amplitude (in Python, tolerances)"


class Criterion(NamedTuple):
    """A criterion: its name, the computed value, the limit, and whether it is met."""

    name: str
    found: float
    limit: float
    passed: bool


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Validation(TableResult, Plottable):
    """A run compared with a measurement.

    Attributes
    ----------
    system : System
        The system of the run, with `parameters` and `separation`.
    measurement : Measurement
        The measured signal, as in its file.
    quantity : str
        The column of the trajectory that the signal is compared with.
    shift : float
        Added to the measured times, s.
    t, measured, computed : ndarray, shape (n,)
        The measured times within the run, s, and both signals at these times.
    band : float or None
        Half width of the tolerance band, in the unit of the quantity.
    rms, greatest : float
        Root mean square and greatest absolute value of the deviation.
    correlation : float
        Correlation coefficient of both signals; 0 if one is constant.
    spectra : tuple of Spectrum
        Spectra of the measured and of the computed signal.
    criteria : tuple of Criterion
        The tolerances, and whether they are met.
    separated, stuck : sequence of (start, end)
        Intervals of separation, and of stick on a belt of finite speed, s.
    """

    data_name: ClassVar[str] = "validation"

    system: System
    measurement: Measurement
    quantity: str
    shift: float
    t: FloatArray
    measured: FloatArray
    computed: FloatArray
    band: float | None
    rms: float
    greatest: float
    correlation: float
    spectra: tuple[Spectrum, Spectrum]
    criteria: tuple[Criterion, ...]
    separated: Sequence[tuple[float, float]] = ()
    stuck: Sequence[tuple[float, float]] = ()

    @property
    def passed(self) -> bool | None:
        """Whether all criteria are met; None if there are none."""
        return all(criterion.passed for criterion in self.criteria) if self.criteria else None

    @property
    def unit(self) -> str:
        """Unit of the quantity."""
        return UNITS[self.quantity]

    @property
    def warning(self) -> str:
        """Warning if the measured column has the name of another quantity; else empty."""
        signal, names = self.measurement.signal, {*QUANTITIES, "t", "time"} - {self.quantity}
        if not has_column_name(signal, tuple(names)):
            return ""
        return f"column {signal!r} of the measured data is compared with {self.quantity}"

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui validate --json`` prints."""
        measured, computed = self.spectra
        return {
            "file": self.measurement.source,
            "columns": [self.measurement.time, self.measurement.signal],
            "quantity": self.quantity,
            "shift": self.shift,
            "window": [float(self.t[0]), float(self.t[-1])],
            "samples": int(self.t.size),
            "deviation": {"rms": self.rms, "max": self.greatest, "correlation": self.correlation},
            "band": self.band,
            "frequency": {"measured": measured.fundamental, "computed": computed.fundamental},
            "half_range": {
                "measured": half_range(self.measured),
                "computed": half_range(self.computed),
            },
            "criteria": [criterion._asdict() for criterion in self.criteria],
            "passed": self.passed,
        }

    def _table(self) -> Table:
        return {
            Column("t", "s", "time of the run"): self.t,
            Column("measured", self.unit, "measured signal"): self.measured,
            Column("computed", self.unit, "computed signal"): self.computed,
        }

    def _header(self) -> dict[str, Any]:
        return self._system_data() | {"validation": self.to_dict()}

    def _sheet(self) -> "Sheet":
        from .charts import validation_sheet

        return validation_sheet(self)

    def _summary(self) -> list[tuple[str, str]]:
        measured, computed = self.spectra
        rows = [
            ("measured", f"{self.measurement.signal} in {self.measurement.source}"),
            ("compared with", f"{self.quantity}, {self.t[0]:.6g} to {self.t[-1]:.6g} s"),
            ("shift of measured times", f"{self.shift:.6g} s"),
            (
                "deviation",
                f"rms {self.rms:.4g} {self.unit}, at most {self.greatest:.4g} {self.unit}, "
                f"correlation {self.correlation:.4f}",
            ),
            (
                "frequency",
                f"measured {measured.fundamental:.5g} Hz, computed {computed.fundamental:.5g} Hz",
            ),
            (
                "half peak-to-peak",
                f"measured {half_range(self.measured):.5g} {self.unit}, "
                f"computed {half_range(self.computed):.5g} {self.unit}",
            ),
        ]
        rows += [(criterion.name, describe_criterion(criterion)) for criterion in self.criteria]
        verdict = {True: "PASS", False: "FAIL", None: _NO_VERDICT}[self.passed]
        rows.append(("verdict", verdict))
        return rows


def describe_criterion(criterion: Criterion) -> str:
    """Value, limit and outcome of a criterion as text."""
    outcome = "passes" if criterion.passed else "fails"
    return f"{criterion.found:.4g} against {criterion.limit:.4g}: {outcome}"


def validate(
    run: Transient,
    measurement: Measurement,
    *,
    quantity: str = "y",
    shift: float | Literal["auto"] = 0.0,
    tolerances: Tolerances | None = None,
) -> Validation:
    """Compare a run with a measurement.

    Parameters
    ----------
    run : Transient
        Computed with ``samples="dense"``, or with sample times close enough for its motion.
    measurement : Measurement
        From `read_measurement`.
    quantity : str
        The measured quantity: ``x``, ``vx``, ``y``, ``vy`` or ``P``, in SI units.
    shift : float or "auto"
        Added to the measured times, s; ``"auto"`` finds the shift of highest correlation that has
        the whole measurement within the run.
    tolerances : Tolerances, optional
        Limits of the deviation; without them there is no verdict.

    Returns
    -------
    Validation
        Deviation, spectra and verdict for the measured times within the run.

    Raises
    ------
    InputError
        If an input is wrong, or fewer than 16 samples are within the run.

    Examples
    --------
    >>> import numpy as np
    >>> from fivtui import read_measurement, simulate, validate
    >>> run = simulate(t_end=30.0, samples="dense")
    >>> t = np.linspace(10.0, 12.0, 201)
    >>> np.savetxt("test.csv", np.column_stack([t - 10.0, run.solution(t).y]), delimiter=",")
    >>> result = validate(run, read_measurement("test.csv"), shift="auto")
    >>> f"{result.shift:.3f} s, correlation {result.correlation:.4f}"
    '10.000 s, correlation 1.0000'
    """
    for name, value, kind in (("run", run, Transient), ("measurement", measurement, Measurement)):
        if not isinstance(value, kind):
            raise InputError(f"{name} = {value!r}: must be a {kind.__name__}")
    check_known("quantity", quantity, QUANTITIES)
    limits = Tolerances() if tolerances is None else tolerances
    if not isinstance(limits, Tolerances):
        raise InputError(f"tolerances = {limits!r}: must be, say, Tolerances(band='5%')")
    shift_s = best_shift(run, measurement, quantity) if shift == "auto" else float(shift)
    if not math.isfinite(shift_s):
        raise InputError(f"shift = {shift_s:g}: must be a time in s, or auto")
    times = measurement.t + shift_s
    is_within = (times >= 0.0) & (times <= run.t_end)
    t, measured = times[is_within], measurement.values[is_within]
    if t.size < _MIN_SAMPLES:
        raise InputError(
            f"{measurement.source}: {t.size} samples are within the run, 0 to {run.t_end:g} s; "
            f"must be at least {_MIN_SAMPLES}: shift the times, or take a longer run"
        )
    computed: FloatArray = getattr(motion_at(run, t), quantity)
    deviation = measured - computed
    spectra = (_resampled_spectrum(t, measured), _resampled_spectrum(t, computed))
    band = None
    if limits.band is not None:
        band = limits.band.value * (half_range(computed) if limits.band.relative else 1.0)
    return Validation(
        run.system,
        measurement,
        quantity,
        shift_s,
        t,
        measured,
        computed,
        band,
        float(np.sqrt(np.mean(deviation**2))),
        float(np.abs(deviation).max()),
        _correlation(measured, computed),
        spectra,
        tuple(_criteria(limits, band, spectra, measured, computed)),
        run.separated_intervals,
        run.stick_intervals,
    )


def half_range(values: FloatArray) -> float:
    """Half peak-to-peak."""
    return 0.5 * float(np.ptp(values))


def _criteria(
    limits: Tolerances,
    band: float | None,
    spectra: tuple[Spectrum, Spectrum],
    measured: FloatArray,
    computed: FloatArray,
) -> list[Criterion]:
    # The criteria that have a limit.
    criteria = []
    if band is not None:
        share = float(np.mean(np.abs(measured - computed) <= band))
        criteria.append(
            Criterion("share within the band", share, limits.share, share >= limits.share)
        )
    for name, limit, (measured_value, computed_value) in (
        ("deviation of frequency", limits.frequency, [entry.fundamental for entry in spectra]),
        ("deviation of amplitude", limits.amplitude, [half_range(v) for v in (measured, computed)]),
    ):
        if limit is not None:
            scale = abs(measured_value) or abs(computed_value)
            difference = abs(computed_value - measured_value) / scale if scale else 0.0
            criteria.append(Criterion(name, difference, limit, difference <= limit))
    return criteria


def _resampled_spectrum(t: FloatArray, values: FloatArray) -> Spectrum:
    # The spectrum of a signal at even times: measured times need not be even.
    even_times = np.linspace(t[0], t[-1], t.size)
    return spectrum(even_times, np.interp(even_times, t, values))


def _correlation(first: FloatArray, second: FloatArray) -> float:
    first, second = first - first.mean(), second - second.mean()
    norm = float(np.sqrt(np.sum(first**2) * np.sum(second**2)))
    return float(np.sum(first * second)) / norm if norm > 0.0 else 0.0


def best_shift(run: Transient, measurement: Measurement, quantity: str) -> float:
    """The shift of measured times, s, with the highest correlation; all samples are in the run."""
    start, end = float(measurement.t[0]), float(measurement.t[-1])
    duration = end - start
    if duration > run.t_end:
        raise InputError(
            f"{measurement.source}: lasts {duration:g} s; for an automatic shift it must fit "
            f"into the run of {run.t_end:g} s"
        )
    # Both signals on a grid of equal steps, without their means.
    step = max(duration / (measurement.t.size - 1), run.t_end / _MAX_GRID_POINTS)
    run_times = np.arange(math.floor(run.t_end / step) + 1) * step
    computed: FloatArray = getattr(motion_at(run, np.minimum(run_times, run.t_end)), quantity)
    measured_times = np.arange(math.floor(duration / step) + 1) * step + start
    signal = np.interp(measured_times, measurement.t, measurement.values)
    signal = signal - signal.mean()
    motion = computed - computed.mean()
    # Covariance of the signal and the run for every offset of the signal in the run.
    fft_size = 1 << (computed.size + signal.size - 1).bit_length()
    cross_spectrum = np.fft.rfft(motion, fft_size) * np.conj(np.fft.rfft(signal, fft_size))
    covariances = np.fft.irfft(cross_spectrum, fft_size)[: computed.size - signal.size + 1]
    # Divide each covariance by the root of Σ(x − mean)² = Σx² − (Σx)²/n over the n samples of the
    # run from the offset on.
    sums, squares = (np.concatenate([[0.0], np.cumsum(motion**power)]) for power in (1, 2))
    n = signal.size
    square_sums = (squares[n:] - squares[:-n]) - (sums[n:] - sums[:-n]) ** 2 / n
    least_sum = _LEAST_SQUARE_SUM * max(float(square_sums.max()), _MIN_DIVISOR)
    scores = covariances / np.sqrt(np.maximum(square_sums, least_sum))
    return float(step * int(scores.argmax()) - start)


def prepare_comparison(options: ValidateOptions) -> Callable[[], Callable[[Transient], Validation]]:
    """A function that reads the measured file and returns one that compares a run with it.

    Raises `InputError` if an option is wrong for any file.
    """
    file, quantity = options.measured, options.quantity
    if file is None:
        raise InputError("--measured FILE.csv: must be given")
    check_known("quantity", quantity, QUANTITIES)
    shift = read_shift(options.shift)
    tolerances = read_tolerances(vars(options), "--")
    numbers = {
        name: parse_number(f"--{name.replace('_', '-')}", text, "a number")
        for name in ("scale", "offset", "time_scale")
        if (text := getattr(options, name)) is not None
    }

    def read() -> Callable[[Transient], Validation]:
        measurement = read_measurement(
            file, time=options.time, signal=options.signal, quantity=quantity, **numbers
        )
        return lambda run: validate(
            run, measurement, quantity=quantity, shift=shift, tolerances=tolerances
        )

    return read


def read_shift(text: str) -> float | Literal["auto"]:
    """Parse a shift of times, s, or ``auto``."""
    if text == "auto":
        return "auto"
    return parse_number("--shift", text, "a time in s, or auto")
