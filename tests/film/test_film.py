"""Films of the slider on the belt: positions and arrows of their frames."""

import json
import math
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from PIL import Image
from PIL.GifImagePlugin import GifImageFile

from fivtui.charts import figure_colour
from fivtui.cli import run as command
from fivtui.film.figure import animate, check_film_path
from fivtui.film.shapes import Shape, layout_of, shapes_at
from fivtui.film.timing import FRAMES_PER_SECOND, film_timing, speed_text
from fivtui.model import Cancelled, InputError, Mode, Parameters, time_scale
from fivtui.signals.motion import motion_at
from fivtui.simulation import simulate
from fivtui.transient import Transient

RUN = simulate(t_end=100.0, samples="dense")
STICKING = simulate(Parameters(v_belt=3.0, mu_s=0.9, v_s=0.4), t_end=20.0, samples="dense")
# Colour of a sticking foot, RGB.
STICK_COLOUR: Final = tuple(bytes.fromhex(figure_colour("series-2", 0.6)[1:]))


def shapes(run: Transient, t: float, belt_travel: float = 0.0) -> dict[str, Shape]:
    motion = motion_at(run, np.linspace(0.0, run.t_end, 4001))
    state = motion_at(run, np.array([t]))
    return shapes_at(run, layout_of(motion), state, belt_travel)


def longest_interval_middle(run: Transient, mode: Mode) -> float:
    intervals = {Mode.SEPARATED: run.separated_intervals, Mode.STICK: run.stick_intervals}[mode]
    start, end = max(intervals, key=lambda pair: pair[1] - pair[0])
    return 0.5 * (start + end)


def test_a_separated_foot_is_y_above_the_belt_without_contact_force() -> None:
    t = longest_interval_middle(RUN, Mode.SEPARATED)
    drawn = shapes(RUN, t)
    assert drawn["foot"].y.min() == pytest.approx(motion_at(RUN, np.array([t])).y[0])
    assert {"contact force", "friction"}.isdisjoint(drawn)


def test_in_contact_the_foot_is_on_the_belt_and_the_arrows_are_the_forces() -> None:
    motion = motion_at(RUN, np.linspace(0.0, 100.0, 4001))
    t = float(motion.t[motion.P.argmax()])
    drawn = shapes(RUN, t)
    assert drawn["foot"].y.min() == 0.0
    force_length = drawn["contact force"].y[1] - drawn["contact force"].y[0]
    friction_length = drawn["friction"].x[1] - drawn["friction"].x[0]
    assert friction_length / force_length == pytest.approx(0.7)
    # The block moves to scale, and no part overlaps the belt.
    rise = drawn["block"].y.min() - shapes(RUN, 0.0)["block"].y.min()
    start_y, final_y = motion_at(RUN, np.array([0.0, t])).y
    assert rise == pytest.approx(final_y - start_y)
    assert drawn["block"].y.min() > drawn["foot"].y.max()


@pytest.mark.parametrize("name", ["contact force", "friction"])
def test_the_barbs_of_an_arrow_are_symmetric(name: str) -> None:
    motion = motion_at(RUN, np.linspace(0.0, 100.0, 4001))
    arrow = shapes(RUN, float(motion.t[motion.P.argmax()]))[name]
    # The line passes its tip a second time between the barbs.
    tail, tip, left_barb, _, right_barb = np.column_stack([arrow.x, arrow.y])
    along = (tip - tail) / np.linalg.norm(tip - tail)
    across = np.array([-along[1], along[0]])
    assert (left_barb - tip) @ along == pytest.approx((right_barb - tip) @ along)
    assert (left_barb - tip) @ along < 0.0
    assert (left_barb - tip) @ across == pytest.approx((tip - right_barb) @ across)
    assert abs((left_barb - tip) @ across) == pytest.approx(-0.5 * ((left_barb - tip) @ along))


def test_marks_travel_with_the_belt_and_all_shapes_are_in_the_picture() -> None:
    layout = layout_of(motion_at(STICKING, np.linspace(0.0, 20.0, 2001)))
    marks_before, marks_after = (
        shapes(STICKING, 5.0, travel)["marks"] for travel in (0.0, 0.01 * layout.size)
    )
    assert marks_after.x[0] - marks_before.x[0] == pytest.approx(0.01 * layout.size)
    for t in np.linspace(0.0, 20.0, 41).tolist():
        state = motion_at(STICKING, np.array([t]))
        for shape in shapes_at(STICKING, layout, state, 0.0).values():
            # The marks slant to the left, the first one beyond the edge.
            assert np.nanmin(shape.x) >= layout.x_range[0] - 0.1 * layout.size, shape.name
            assert np.nanmax(shape.x) <= layout.x_range[1], shape.name
            assert np.nanmin(shape.y) >= layout.y_range[0], shape.name
            assert np.nanmax(shape.y) <= layout.y_range[1], shape.name


def test_a_belt_whose_speed_follows_a_table_travels_by_its_integral() -> None:
    braking = simulate(t_end=10.0, over_time={"v_belt": [(2.0, 3.0), (6.0, 0.0)]}, samples="dense")
    timing = film_timing(braking, (0.0, 10.0), 1.0)
    travels = [timing.belt_travel(braking, t, 1.0) for t in (0.0, 1.0, 2.0, 4.0, 6.0, 10.0)]
    assert travels == pytest.approx([0.0, 3.0, 6.0, 10.5, 12.0, 12.0])
    start, end = max(braking.stick_intervals, key=lambda pair: pair[1] - pair[0])
    # The friction that holds a sticking slider has an arrow, too.
    friction_tail, friction_tip, *_ = shapes(braking, 0.5 * (start + end))["friction"].x
    assert friction_tip != friction_tail


def test_a_film_shows_the_modes_by_the_colour_of_the_foot(tmp_path: Path) -> None:
    start, end = max(STICKING.stick_intervals, key=lambda pair: pair[1] - pair[0])
    # Three frames, one interval of the film apart, span the stick.
    speed = (end - start) / 2.0 * FRAMES_PER_SECOND
    separated_time = longest_interval_middle(STICKING, Mode.SEPARATED)
    counts = {}
    for name, window in (
        ("stick", (start, end)),
        ("off", (separated_time - 0.01, separated_time + 0.01)),
    ):
        film_speed = speed if name == "stick" else 0.25
        film = animate(STICKING, tmp_path / f"{name}.gif", window=window, speed=film_speed)
        assert film.frames == 3
        with Image.open(film.path) as image:
            assert isinstance(image, GifImageFile)
            assert image.n_frames == 3
            assert image.info["duration"] == 40
            image.seek(1)
            pixels = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(int)
        counts[name] = int((np.abs(pixels - STICK_COLOUR).max(axis=1) < 40).sum())
    # Both pictures show this colour in the legend and the curve; the foot adds at least 300 pixels.
    assert counts["stick"] > counts["off"] + 300


def test_by_default_a_film_has_ten_seconds_of_the_last_cycles() -> None:
    timing = film_timing(RUN, None, None)
    assert timing.end == 100.0
    assert 9.0 < timing.times.size / FRAMES_PER_SECOND < 11.0
    assert film_timing(RUN, None, 2.0).start == 80.0
    assert film_timing(RUN, (0.0, 10.0), 1.0).times.size == 251
    assert film_timing(RUN, (0.0, 1.0), 25.0).times.size == 2
    shortest = 1e-3 * time_scale(RUN.parameters)
    assert film_timing(RUN, (0.0, 1.01 * shortest), None).times.size > 200
    with pytest.raises(InputError, match="show no motion"):
        film_timing(RUN, (0.0, 0.99 * shortest), None)
    assert [speed_text(speed) for speed in (1.0, 2.0, 0.01)] == [
        "real time", "2 times real time", "slowed down 100 times",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("window", "speed", "refusal"),
    [
        ((0.0, 100.0), 0.01, "must be at most 1000"),
        ((0.0, 1.0), 0.0, "must be above 0"),
        (None, math.inf, "must be above 0"),
        ((5.0, 4.0), None, "must be two ascending times"),
        (None, 1e-12, r"^window: 1e-11 s show no motion; must be at least \d"),
        ((0.0, 1e-9), None, r"^window: 1e-09 s show no motion; must be at least \d"),
        (None, 1e12, r"^speed = 1e\+12: 100 s are shorter than one frame"),
        ((0.0, 1.0), 25.1, "1 s are shorter than one frame"),
    ],
)
def test_runs_that_cannot_be_filmed_are_refused(
    window: tuple[float, float] | None, speed: float | None, refusal: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=refusal):
        animate(RUN, tmp_path / "a.gif", window=window, speed=speed)
    assert not list(tmp_path.iterdir())


def test_mp4_is_refused_in_one_line_without_ffmpeg(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(FFMpegWriter, "isAvailable", lambda: False)
    assert command(["animate", "--out", str(tmp_path / "a.mp4")]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert "MP4 needs ffmpeg" in message
    monkeypatch.setattr(FFMpegWriter, "isAvailable", lambda: True)
    check_film_path(tmp_path / "a.mp4")
    with pytest.raises(InputError, match="suffix of a film file"):
        check_film_path(tmp_path / "a.avi")


@pytest.mark.host
@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="ffmpeg is not installed")
def test_mp4_is_written_if_ffmpeg_is_installed(tmp_path: Path) -> None:
    film = animate(RUN, tmp_path / "a.mp4", window=(90.0, 90.2), speed=1.0)
    assert film.path.read_bytes()[4:8] == b"ftyp"


def test_a_film_that_is_stopped_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(Cancelled):
        animate(RUN, tmp_path / "a.gif", window=(1.0, 2.0), progress=lambda _: False)
    assert not list(tmp_path.iterdir())


def test_a_slider_at_rest_is_drawn_with_a_contact_force_and_no_friction() -> None:
    drawn = shapes(simulate(Parameters(mu=0.0), t_end=1.0, samples=3), 0.5)
    assert drawn["contact force"].y[1] > 0.0
    assert np.ptp(drawn["friction"].x) == pytest.approx(0.0)


def test_the_command_reports_the_window_and_the_slider_moves_between_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = [
        "animate",
        "--t-end",
        "20",
        "--window",
        "10:10.1",
        "--speed",
        "1.25",
        "--out",
        "a.gif",
    ]
    assert command([*arguments, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report == {"path": "a.gif", "window": [10.0, 10.1], "speed": 1.25, "frames": 3}
    with Image.open("a.gif") as image:
        assert isinstance(image, GifImageFile)
        frames = []
        for number in (0, image.n_frames - 1):
            image.seek(number)
            frames.append(np.asarray(image.convert("RGB")).astype(int))
    assert (np.abs(frames[0] - frames[1]).max(axis=2) > 60).sum() > 1000
    assert command(arguments) == 2
    assert "exists already" in capsys.readouterr().err
