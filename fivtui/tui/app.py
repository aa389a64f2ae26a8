"""The Textual application: restores a session, displays it, and saves it at intervals."""

import asyncio
import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path, PurePath
from typing import Any, ClassVar, Final, cast

from textual import on
from textual._compositor import CompositorUpdate
from textual.app import App
from textual.binding import Binding, BindingType
from textual.command import Provider
from textual.drivers._writer_thread import WriterThread
from textual.events import CursorPosition, Event, InputEvent, Key, MouseMove, Paste, Resize
from textual.geometry import Region
from textual.screen import Screen
from textual.theme import BUILTIN_THEMES, Theme

from fivtui.model import InputError, unknown_name_error
from fivtui.scene import Scene
from fivtui.tui.chart import Pictures, TerminalReply, with_chart_colours

from .lab import (
    KEY_IDS,
    KeyQueue,
    LabScreen,
    TerminalLine,
    VerdictView,
    discard_alt_character,
    key_names,
    register_alt_keys,
)
from .persistence import Autosave, Config, State, load_config, session_state
from .session import SCREEN_RESPONSE, ComputingThreads, Session
from .tabs import Reported

_SAVE_INTERVAL_S: Final = 2.0
_STYLES: Final = Path(__file__).parent / "styles"
# Signals that end the program; Windows has no SIGHUP.
_TERMINATION_SIGNALS: Final = tuple(
    signal.Signals[name] for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)
)
# Environment variables that name the terminal.
_TERMINAL_NAMES: Final = ("TERM", "TERM_PROGRAM")
# Beginnings of the names of terminals that are not asked for pictures: they would display the query
# as text or as a title, or answer for a terminal that they do not know.
_PLAIN_TERMINALS: Final = ("linux", "dumb", "screen", "tmux", "Apple_Terminal")
# A program ended by a signal exits with this status plus the number of the signal.
SIGNAL_STATUS_BASE: Final = 128
# Time limit for restoring the terminal after a signal, s; a closed terminal may block.
_RESTORE_TIMEOUT_S: Final = 5.0
# Time in which the terminal answers the last query about its cursor, s.
_LAST_ANSWER_S: Final = 0.2
# Time without a change of the terminal's size that ends a storm of sizes, and on a slow line, s.
_SIZE_PAUSE_S: Final = 0.12
_SLOW_SIZE_PAUSE_S: Final = 0.3


def _command_provider() -> type[Provider]:
    from .lab import LabCommands

    return LabCommands


class FivtuiApp(App[None]):
    """The terminal laboratory: restores, displays and saves a session."""

    TITLE = "fivtui"
    CSS_PATH: ClassVar[list[str | PurePath]] = [
        _STYLES / "lab.tcss",
        _STYLES / "charts.tcss",
        _STYLES / "dialogs.tcss",
    ]
    COMMANDS: ClassVar[set[type[Provider] | Callable[[], type[Provider]]]] = {_command_provider}
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(
            "ctrl+q",
            "quit",
            "Quit",
            tooltip="Quit; the next start restores the session",
            priority=True,
        ),
    ]
    # A Textual mode per session, so that sessions can be switched.
    DEFAULT_MODE = "session"
    # Minimum columns and rows of the screen, and the class that the style sheets use from there on.
    HORIZONTAL_BREAKPOINTS = [  # noqa: RUF012 (typed as in the base class)
        (0, "-cramped"),
        (40, "-narrow"),
        (80, "-regular"),
        (120, "-broad"),
        (180, "-wide"),
    ]
    VERTICAL_BREAKPOINTS = [  # noqa: RUF012 (typed as in the base class)
        (0, "-flat"),
        (10, "-tiny"),
        (16, "-low"),
        (24, "-short"),
        (30, "-middle"),
        (36, "-tall"),
    ]

    def __init__(
        self,
        scene: Scene | None = None,
        source: str = "",
        *,
        state: Path | None = None,
        config: Path | None = None,
        on_first_frame: Callable[[], None] = lambda: None,
        threads: ComputingThreads | None = None,
    ) -> None:
        register_alt_keys()
        super().__init__()
        for theme in BUILTIN_THEMES.values():
            self.register_theme(with_chart_colours(theme))
        self._pictures = Pictures(self, SCREEN_RESPONSE.wait, self._report)
        self._on_first_frame = on_first_frame
        self._threads = threads
        self.session = Session()
        self._keys = KeyQueue(self, self._handle_event)
        self._line = TerminalLine(self, self._pictures, self._urgent_regions)
        # The change of the terminal's size after which a pause is awaited.
        self._awaited_size_event: Resize | None = None
        self.add_mode(self.DEFAULT_MODE, self.get_default_screen)
        self._state_file = state
        self.autosave = Autosave(state)
        # The last reported error of saving.
        self._reported_error = ""
        self._is_first_start = False
        # Reports to be posted when the screen is displayed.
        self._reports: list[Reported] = []
        # It overrides the theme of the saved session, and whether a live curve follows its edits.
        self._config = self._configure(config)
        self._restore(scene, source)

    def _configure(self, path: Path | None) -> Config:
        try:
            config = load_config(path, KEY_IDS)
            for name, colours in config.themes.items():
                theme = Theme(name, **cast("dict[str, Any]", colours))
                self.register_theme(with_chart_colours(theme, chosen=colours))
            if config.theme and config.theme not in self.available_themes:
                raise unknown_name_error("theme", config.theme, self.available_themes)
        except InputError as error:
            self._reports.append(Reported(f"{path}: {error}", error=True))
            return Config()
        self.set_keymap(config.keys)
        if config.theme:
            self.theme = config.theme
        return config

    def _restore(self, scene: Scene | None, source: str) -> None:
        session = self.autosave.load()
        self._is_first_start = (
            bool(self.autosave.number) and session is None and not self.autosave.other_slots
        )
        self._reports += [Reported(text, error=True) for text in self.autosave.notices]
        if session is not None:
            self._open(session, "last session restored", routine=True)
        if scene is not None:
            # As where it is opened in the laboratory: undo restores the scene of the session.
            self.session.load(scene, source)
            self.session.add_recent(source)
            self._reports.append(Reported(f"scene {scene.name} opened: {source}", routine=True))
        numbers = ", ".join(str(slot.number) for slot in reversed(self.autosave.other_slots))
        if numbers:
            text = f"session {self.autosave.number}; other saved sessions: {numbers} (Ctrl+P, Open)"
            self._reports.append(Reported(text))

    def _open(self, session: Session, text: str, *, routine: bool) -> None:
        # A routine report is logged; others, and those on results that were not saved, are
        # displayed, too.
        if session.theme in self.available_themes and not self._config.theme:
            self.theme = session.theme
        self.session = session
        notes = [f"{key} was not saved: {reason}" for key, reason in session.not_stored.items()]
        text = "; ".join([text, *notes])
        self._reports.append(Reported(text, routine=routine and not notes))

    def action_open_session(self, number: int) -> None:
        """Open another saved session."""
        autosave = Autosave(self._state_file)
        try:
            session = autosave.open(number)
        except InputError as error:
            self._report(str(error), error=True)
            return
        self.autosave.close(self._session_state())
        self.autosave, self._reported_error = autosave, ""
        self._open(session, f"session {number} opened", routine=False)
        # Removing the screen of the previous session ends its computations.
        previous_mode, mode = self.current_mode, f"session {number}"
        self.add_mode(mode, self.get_default_screen)
        self.switch_mode(mode)
        self.remove_mode(previous_mode)
        self._start_screen()

    def get_default_screen(self) -> LabScreen:
        """The laboratory's screen."""
        self.session.key_names = key_names(self, self._config.keys)
        if self._config.live is not None:
            self.session.live_enabled = self._config.live
        screen = LabScreen(
            self.session,
            lambda: self.autosave.other_slots,
            has_waiting_keys=lambda: bool(self._keys.events),
            show_welcome=self._is_first_start,
        )
        # Size classes set before the first layout avoid a second one.
        width, height = self.size
        sizes = ((width, self.HORIZONTAL_BREAKPOINTS), (height, self.VERTICAL_BREAKPOINTS))
        screen.set_classes(
            next(name for minimum, name in reversed(breakpoints) if size >= minimum)
            for size, breakpoints in sizes
        )
        return screen

    @on(TerminalReply)
    def _read_reply(self, event: TerminalReply) -> None:
        if self.screen_stack:
            self._pictures.read(event)

    def _display(self, screen: Screen[Any], renderable: Any) -> None:
        is_update = isinstance(renderable, CompositorUpdate)
        if is_update and self.screen_stack and not self._batch_count:
            renderable = self._line.fit(screen, renderable)
        super()._display(screen, renderable)

    def _check_resize(self) -> None:
        size_event = self._resize_event
        if size_event is not self._awaited_size_event:
            # Laying out every size of a storm would delay the verdict, so await its end.
            self._awaited_size_event = size_event
            pause = _SLOW_SIZE_PAUSE_S if self._line.is_slow else _SIZE_PAUSE_S
            self._resize_timer = self.set_timer(pause, self._check_resize)
        else:
            self._line.forget_cells()
            super()._check_resize()

    def _report(self, text: str, *, error: bool = False) -> None:
        self.screen_stack[0].post_message(Reported(text, error=error))

    async def action_quit(self) -> None:
        """Quit when the terminal has answered."""
        if self._line.awaits_answer:
            # An answer that the terminal sends after the end would be typed into the shell.
            await asyncio.sleep(_LAST_ANSWER_S)
        await super().action_quit()

    def _install_signal_handlers(self) -> None:
        # Unavailable on Windows and outside the main thread.
        with suppress(NotImplementedError, RuntimeError, ValueError):
            for number in _TERMINATION_SIGNALS:
                asyncio.get_running_loop().add_signal_handler(number, self._terminate, number)

    def _end_without_terminal(self) -> None:
        # A program that does not control its terminal gets no signal when the terminal is closed.
        # The thread that writes to it fails, and the program would wait for that thread for ever.
        report_error, loop = threading.excepthook, asyncio.get_running_loop()

        def end(error: threading.ExceptHookArgs) -> None:
            if not isinstance(error.thread, WriterThread):
                report_error(error)
                return
            loop.call_soon_threadsafe(self._terminate, _TERMINATION_SIGNALS[-1])
            # Drop what the program still writes, up to the None that ends the thread.
            while error.thread._queue.get() is not None:
                pass

        threading.excepthook = end

    def _terminate(self, number: signal.Signals) -> None:
        """Save the session, restore the terminal and quit because of a signal."""
        status = SIGNAL_STATUS_BASE + number
        exit_timer = threading.Timer(_RESTORE_TIMEOUT_S, os._exit, (status,))
        exit_timer.daemon = True
        exit_timer.start()
        # Save first: the terminal may be closed.
        self.autosave.close(self._session_state())
        self.exit(return_code=status)

    def on_load(self) -> None:
        """Set the executor that runs computations in threads, and how tasks start."""
        loop = asyncio.get_running_loop()
        # From Python 3.12 on, Textual starts tasks eagerly. The screen of a mode would then compose
        # its inputs before it is on the stack, which they need (Textual issue 6444).
        loop.set_task_factory(None)
        if self._threads is not None:
            loop.set_default_executor(self._threads)

    def on_mount(self) -> None:
        """Start saving the session at intervals, and report what was restored."""
        if self.autosave.number:
            self.set_interval(_SAVE_INTERVAL_S, self._save_session)
        if not self.is_headless and self._driver is not None:
            self._install_signal_handlers()
            self._end_without_terminal()
            self._line.open(self._driver.write)
        self._start_screen()

    def _start_screen(self) -> None:
        screen = cast("LabScreen", self.screen_stack[0])
        for report in self._reports:
            screen.post_message(report)
        self._reports.clear()
        # After the first frame, because loading the kernel is slow.
        self.call_after_refresh(self._report_interpreted_kernel)
        if self.session.unread_results:
            store, unread = self.autosave.store, dict(self.session.unread_results)
            # After the first frame, because reading files may be slow.
            self.call_after_refresh(
                screen.run_in_thread,
                "restoring",
                lambda: screen.call_later(screen.restore_results, *store.read(unread)),
            )

    def _report_interpreted_kernel(self) -> None:
        from fivtui.kernel import why_interpreted

        if reason := why_interpreted():
            self._report(f"runs are interpreted, which takes long: {reason}")

    async def on_event(self, event: Event) -> None:
        """Queue keys and pasted text, to handle them in order; handle other events at once."""
        if isinstance(event, Key | Paste) and not event.is_forwarded:
            await self._keys.enqueue(event)
        else:
            await self._handle_event(event)

    async def _handle_event(self, event: Event) -> None:
        """Pause computing threads after input, and remove the text of keys with Alt."""
        if isinstance(event, InputEvent):
            if not self.screen_stack:
                # The application has quit.
                return
            if isinstance(event, Key):
                # In the laboratory, the characters of a Mac's Option key count as Alt with a digit.
                discard_alt_character(event, mac_option=isinstance(self.screen, LabScreen))
            if not isinstance(event, MouseMove):
                SCREEN_RESPONSE.begin()
                self._pictures.note_key()
        await super().on_event(event)

    def _urgent_regions(self) -> list[Region]:
        # What a slow line draws first: what is edited, and the verdict.
        screen = self.screen
        urgent = [*screen.query("#headline"), screen.focused, *screen.query(VerdictView)]
        return [widget.region for widget in urgent if widget is not None]

    def on_cursor_position(self, event: CursorPosition) -> None:
        """Hand the answer of the terminal to the line that draws the screen."""
        self._line.answer(event)

    def on_ready(self) -> None:
        """Report that the first screen is displayed, and ask whether there can be pictures."""
        self._on_first_frame()
        # In a browser, the variables are those of the server's terminal.
        names = [] if self.is_web else [os.environ.get(name, "") for name in _TERMINAL_NAMES]
        is_plain = self.no_color or any(name.startswith(_PLAIN_TERMINALS) for name in names)
        is_able = self._pictures.can_ask and not is_plain
        if self._config.pictures and is_able and self._driver is not None:
            self._pictures.start(self._driver.write)

    def _session_state(self) -> State:
        self.session.theme = self.theme
        return session_state(self.session)

    def _save_session(self) -> None:
        if self.autosave.save_error != self._reported_error:
            self._reported_error = self.autosave.save_error
            text = self._reported_error or "the session is saved again"
            self._report(text, error=bool(self._reported_error))
        autosave, state = self.autosave, self._session_state()
        if autosave.needs_save(state):
            # In a thread, because writing files may be slow.
            self.run_worker(lambda: autosave.save(state), thread=True, exit_on_error=False)

    def on_unmount(self) -> None:
        """Save the session, whatever ended the application."""
        self.autosave.close(self._session_state())
