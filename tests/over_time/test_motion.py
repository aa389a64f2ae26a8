"""Motion while preload, friction and the belt's speed follow tables."""

import dataclasses
import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fivtui import Parameters, find_scene, load_scene, save_scene, simulate
from fivtui.cli import run as command
from fivtui.model import InputError, System, TimeTable, time_tables
from fivtui.scene import read_over_time
from fivtui.simulation import compute
from fivtui.transient import START_SEEDS, Request, compute_variation
from tests.support.independent_belt import IndependentBelt, integrate

Tables = dict[str, list[tuple[float, float]]]
RAMPS: Tables = {
    "F": [(0, 20), (4, 100), (10, 100), (12, 60)],
    "mu": [(0, 0.2), (4, 0.2), (8, 0.8)],
}


def state_without_time(final: tuple[float, ...]) -> list[float]:
    return list(final[1:])


@pytest.mark.parametrize("separation", [True, False])
def test_constant_tables_change_nothing(separation: bool) -> None:
    for p in (Parameters(), Parameters(v_belt=2.0, mu_s=0.9, v_s=0.4)):
        values = {
            name: value for name in ("F", "mu", "v_belt") if (value := getattr(p, name)) is not None
        }
        rows: Tables = {
            name: [(0, value), (3.3, value), (8, value)] for name, value in values.items()
        }
        constant_run = simulate(p, t_end=12.0, separation=separation)
        run = simulate(p, t_end=12.0, separation=separation, over_time=rows)
        assert run.switch_times == pytest.approx(constant_run.switch_times, abs=1e-11)
        assert run.events.transitions == constant_run.events.transitions
        assert state_without_time(run.final) == pytest.approx(
            state_without_time(constant_run.final), abs=1e-10
        )
        assert run.peak == pytest.approx(constant_run.peak, abs=1e-10)


def test_ramps_agree_with_an_independent_integrator() -> None:
    p = Parameters()

    def table_value(t: float, name: str) -> float:
        return float(np.interp(t, *np.array(RAMPS[name]).T))

    def rates(t: float, state: Any) -> list[float]:
        x, vx, y, vy = state
        force = max(-p.k2 * y - p.k_nl * y**3, 0.0)
        coupling = 0.5 * p.k3 * (x - y)
        ax = (table_value(t, "mu") * force - p.c1 * vx - p.k1 * x - coupling) / p.m
        return [vx, ax, vy, (force - table_value(t, "F") - p.c2 * vy + coupling) / p.m]

    run = simulate(p, t_end=15.0, over_time=RAMPS)
    state = list(run.start)
    rows = sorted({t for table in RAMPS.values() for t, _ in table} | {15.0})
    rows += [float(t) for t in run.switch_times]
    for begin, end in itertools.pairwise(sorted(rows)):
        solution = solve_ivp(rates, (begin, end), state, method="DOP853", rtol=1e-12, atol=1e-13)
        state = solution.y[:, -1].tolist()
    assert state_without_time(run.final) == pytest.approx(state, abs=2e-8)
    assert run.parameters.F == 20.0
    assert run.over_time["F"].rows() == RAMPS["F"]


def test_a_slider_slips_from_a_braking_belt_when_static_friction_is_exceeded() -> None:
    # The slider sticks, x = v₀ t − a t²/2, until the force k1 x − m a that holds it reaches μ_s P,
    # with P = F.
    p = Parameters(m=1.0, k1=1.0, k2=1.0, k3=0.0, c1=0.0, c2=0.0, F=1.0, k_nl=0.0, mu=0.5, mu_s=1.0)
    speed, brake = 2.0, 0.25
    run = simulate(
        p,
        t_end=3.0,
        start=(0.0, speed, -1.0, 0.0),
        over_time={"v_belt": [(0.0, speed), (speed / brake, 0.0)]},
    )
    static_limit = 1.0

    def excess_force(t: float) -> float:
        x = speed * t - 0.5 * brake * t * t
        return p.k1 * x - p.m * brake - static_limit

    slip = brentq(excess_force, 0.1, 2.0, xtol=1e-15)
    (first, *_) = run.mode_changes
    assert (first.first.name, first.then.name) == ("STICK", "FORWARD")
    assert first.t == pytest.approx(slip, abs=1e-13)


def test_a_slider_that_sticks_slips_when_the_speed_of_its_belt_jumps() -> None:
    p = Parameters(m=1.0, k1=0.1, k2=1.0, k3=0.0, c1=0.0, c2=0.0, F=1.0, k_nl=0.0, mu=0.5, mu_s=1.0)
    for final_speed, mode in ((0.2, "BACKWARD"), (3.0, "FORWARD")):
        rows = [(0.0, 1.0), (1.0, 1.0), (1.0, final_speed)]
        run = simulate(p, t_end=1.5, start=(0.0, 1.0, -1.0, 0.0), over_time={"v_belt": rows})
        (first, *_) = run.mode_changes
        assert (first.t, first.first.name, first.then.name) == (1.0, "STICK", mode)
        # After the jump the mass oscillates about x = ±μ F/k1.
        mean, frequency = 5.0 if mode == "FORWARD" else -5.0, math.sqrt(0.1)
        angle = frequency * 0.5
        x = mean + (1.0 - mean) * math.cos(angle) + math.sin(angle) / frequency
        assert run.final.x == pytest.approx(x, abs=1e-12)


# At the end the belt is at rest, or runs backward.
@pytest.mark.parametrize("final_speed", [0.0, -1.5])
@pytest.mark.parametrize("seed", range(4))
def test_random_brake_applications_agree_with_an_event_driven_integration(
    seed: int, final_speed: float
) -> None:
    rng = np.random.default_rng(seed)
    mu = float(rng.uniform(0.2, 0.6))
    p = Parameters(
        mu=mu,
        mu_s=mu + 0.2,
        v_s=float(rng.uniform(0.3, 1.0)),
        c1=2.0,
        c2=3.0,
        F=float(rng.uniform(40, 90)),
    )
    speed = float(rng.uniform(1.0, 3.0))
    tables: Tables = {
        "F": [(0, 15), (1.5, float(rng.uniform(40, 90)))],
        "v_belt": [(0, speed), (2, speed), (5, final_speed)],
    }
    run = simulate(p, t_end=6.5, over_time=tables)
    expected = integrate(IndependentBelt(p, True, tables), np.array(run.start), 6.5)[0]
    assert state_without_time(run.final) == pytest.approx(expected, abs=2e-6), (
        run.events.transitions
    )


def test_the_preset_squeals_groans_and_comes_to_rest() -> None:
    scene = find_scene("brake-stop")
    run = simulate(scene.parameters, t_end=scene.t_end, over_time=dict(scene.over_time))
    # Start of squeal, start and end of groan, and start of the final stick, s.
    stop = run.stop
    assert stop is not None
    assert 4.0 < (stop.squeal or 0.0) < (stop.groan_begin or 0.0) < 24.0
    # The groan ends where the final stick begins.
    assert stop.groan_end == stop.final_stick == run.stick_intervals[-1][0]
    assert (stop.final_stick or 0.0) > 24.0
    assert run.final.vx == 0.0
    stop_after_5_s = simulate(scene.parameters, t_end=5.0, over_time=dict(scene.over_time)).stop
    assert stop_after_5_s == (None, None, None, None)


def test_a_groan_is_the_last_series_of_cycles_that_all_stick() -> None:
    scene = find_scene("brake-stop")
    tables = dict(scene.over_time)
    run = simulate(scene.parameters, t_end=scene.t_end, over_time=tables)
    stop, sticks = run.stop, run.stick_intervals
    assert stop is not None
    # Two sticks during squeal, six seconds of sliding, then one stick per cycle.
    assert sticks[2][0] - sticks[1][1] > 6.0
    assert stop.groan_begin == sticks[2][0]
    assert max(later[0] - early[1] for early, later in itertools.pairwise(sticks[2:])) < 1.3
    # A run that ends earlier has no final stick: its groan ends with its last stick, or with the
    # run if sliding began just before the end.
    for t_end, begin, end in (
        (14.0, sticks[0][0], sticks[1][1]),
        (12.0, sticks[0][0], 12.0),
        (22.0, sticks[2][0], 22.0),
    ):
        shorter_stop = simulate(scene.parameters, t_end=t_end, over_time=tables).stop
        assert shorter_stop is not None
        assert shorter_stop.groan_end == pytest.approx(end, abs=1e-12)
        assert shorter_stop.groan_begin == begin
    # A single stick is no groan.
    single_stick_stop = simulate(scene.parameters, t_end=10.5, over_time=tables).stop
    assert single_stick_stop is not None
    assert single_stick_stop.groan_begin is single_stick_stop.groan_end is None


def test_scenes_with_tables_are_written_and_read(tmp_path: Path) -> None:
    scene = find_scene("brake-stop")
    save_scene(scene, tmp_path / "stop.toml")
    assert load_scene(tmp_path / "stop.toml") == scene


def test_a_scene_takes_columns_of_measured_values(tmp_path: Path) -> None:
    (tmp_path / "stop.csv").write_text("t,bar,speed\n0,1,10\n4,5,10\n24,5,0\n")
    (tmp_path / "stop.toml").write_text(
        'fivtui_scene = 1\n[over_time]\nfile = "stop.csv"\ntime = "t"\nv_belt = "speed"\n'
        'F = {column = "bar", scale = 12.5, offset = -2.5}\n'
    )
    scene = load_scene(tmp_path / "stop.toml")
    assert dict(scene.over_time) == {
        "F": TimeTable((0.0, 4.0, 24.0), (10.0, 60.0, 60.0)),
        "v_belt": TimeTable((0.0, 4.0, 24.0), (10.0, 10.0, 0.0)),
    }
    assert (scene.parameters.F, scene.parameters.v_belt) == (10.0, 10.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("over_time = 3", "over_time = 3: must be a table such as"),
        ("[over_time]\nF = 3", "must be rows of time and value"),
        ("[over_time]\nfile = 3", "must be the name of a file in quotes"),
        ('[over_time]\nfile = "no.csv"\nF = "p"', "no.csv"),
        ('[over_time]\nfile = "a.csv"\nG = "p"', "unknown key of over_time 'G'"),
        ('[over_time]\nfile = "a.csv"\nF = "p"', "there is no column p; it has time, bar"),
        ('[over_time]\nfile = "a.csv"', "a.csv: column bar: must be one of time, F, "),
        ('[over_time]\nfile = "a.csv"\nF = {column = "bar", scale = "x"}', "not a number"),
        ('[over_time]\nfile = "a.csv"\nF = {column = "bar", shift = 1}', "unknown key of F"),
    ],
)
def test_invalid_tables_in_a_scene_are_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.csv").write_text("time,bar\n0,1\n1,2\n")
    (tmp_path / "s.toml").write_text(f"fivtui_scene = 1\n{text}\n")
    with pytest.raises(InputError) as caught:
        load_scene(tmp_path / "s.toml")
    assert message in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path))


def test_commands_take_tables_or_refuse_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "in.csv"
    table.write_text("time,F,mu\n0,20,0.2\n4,100,0.2\n8,100,0.8\n")
    out = tmp_path / "out.csv"
    arguments = ["simulate", "--t-end", "6", "--over-time", str(table), "--out", str(out)]
    assert command(arguments) == 0
    assert "F over time" in capsys.readouterr().out
    rows = [[[0.0, 20.0], [4.0, 100.0], [8.0, 100.0]], [[0.0, 0.2], [4.0, 0.2], [8.0, 0.8]]]
    tables = dict(zip(("F", "mu"), rows, strict=True))
    assert f"# over_time: {json.dumps(tables)}\n" in out.read_text()
    for arguments in (["stability"], ["branch"], ["attractors"], ["accuracy"], ["tradeoff"]):
        assert command([*arguments, "brake-stop"]) == 2
        assert "F, v_belt over time: must be constant for this command" in capsys.readouterr().err
    assert command(["simulate", "brake-stop", "--set", "F=3"]) == 2
    assert "F: follows a table over time; must not be set" in capsys.readouterr().err
    assert command(["simulate", "brake-stop", "--method", "rk4"]) == 2
    assert "F, v_belt over time: the method must be taylor or fmu-native, not rk4" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,F,Mu\n0,1,0.2\n", "{}: column Mu: must be one of time, F, mu, v_belt, "),
        ("time,F,m\n0,1,5\n", "{}: column m: must be one of time, F, mu, v_belt, "),
        ("time,F,F\n0,1,2\n", "{}: column F is given twice; must be given once"),
        ("t,F\n0,1\n", "{}: there is no column time; it has t, F"),
        ("time\n0\n", "{}: must have a column of F, mu, v_belt, "),
    ],
)
def test_unsuitable_columns_of_a_table_are_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_over_time(path)
    assert message.format(path) in str(caught.value)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_tables_may_have_semicolons_or_tabs_and_decimal_commas(
    tmp_path: Path, separator: str
) -> None:
    text = "# F in N\n\ntime;F\n0;1,5\n1;2,5\n".replace(";", separator)
    (tmp_path / "a.csv").write_text(text)
    assert dict(read_over_time(tmp_path / "a.csv")) == {"F": TimeTable((0.0, 1.0), (1.5, 2.5))}


def test_tables_of_a_file_replace_those_of_the_same_parameters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "in.csv"
    table.write_text("time,k2,F\n0,50,5\n1,40,9\n")
    simulate_stop = ["simulate", "brake-stop", "--t-end=1", "--over-time", str(table)]
    assert command(simulate_stop) == 0
    output = capsys.readouterr().out
    assert "5 (0 s) → 9 (1 s)" in output
    assert "50 (0 s) → 40 (1 s)" in output
    assert "10 (0 s) → 10 (4 s) → 0 (24 s)" in output
    assert command([*simulate_stop, "--set", "k2=20"]) == 2
    assert "k2: follows a table over time; must not be set" in capsys.readouterr().err


def test_static_friction_is_compared_with_the_table_of_the_friction_coefficient(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "mu.csv"
    table.write_text("time,mu\n0,0.3\n1,0.5\n")
    arguments = ["simulate", "--t-end=1", "--over-time", str(table), "--set", "v_belt=1"]
    assert command([*arguments, "--set", "mu_s=0.6"]) == 0
    assert command([*arguments, "--set", "mu_s=0.4"]) == 2
    assert "mu over time: reaches 0.5: must be at most mu_s = 0.4" in capsys.readouterr().err


def test_rows_may_come_from_an_iterator_and_serve_several_runs() -> None:
    rows = [(0.0, 20.0), (1.0, 60.0)]
    request = Request(System(Parameters(), over_time=time_tables({"F": iter(rows)})), t_end=2.0)
    shorter = dataclasses.replace(request, t_end=1.5)
    final = simulate(t_end=1.5, over_time={"F": rows}).final
    assert compute(shorter).final == final


def test_options_that_need_constant_parameters_are_refused() -> None:
    scene: Tables = {"F": [(0, 10), (1, 20)]}
    wrong: tuple[tuple[dict[str, Any], str], ...] = (
        ({"kernel": "exact"}, "the kernel must not be exact"),
        ({"sensitivities": ["mu"]}, "has no sensitivities"),
        ({"method": "fmu"}, "the method must be taylor or fmu-native"),
        ({"method": "fmu-native", "sensitivities": ["mu"]}, "must be taylor, not fmu-native"),
    )
    # `START_SEEDS` asks for the derivatives by the start.
    with pytest.raises(InputError, match="F over time: must be constant for derivatives"):
        compute_variation(Request(System(Parameters(), over_time=time_tables(scene))), START_SEEDS)
    for options, message in wrong:
        with pytest.raises(InputError, match=message):
            simulate(t_end=1.0, over_time=scene, **options)
