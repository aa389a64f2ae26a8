"""Editors of fields: text, choices and the check box of separation."""

from typing import Any, ClassVar, Self

from textual import on
from textual.binding import Binding, BindingType
from textual.events import Key
from textual.geometry import Region
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Checkbox, Input, Select

from fivtui.transient import WITH_SEPARATION, WITHOUT_SEPARATION
from fivtui.tui.chart import TextInput
from fivtui.tui.session import FormField
from fivtui.tui.tabs import FieldEdited, FieldStepped, TabKeyPressed


class Editor(Widget):
    """An input with a `value` that edits the text of a field."""

    field: FormField
    value: Any

    @property
    def text(self) -> str:
        """The displayed text."""
        return str(self.value)

    @text.setter
    def text(self, text: str) -> None:
        self.value = text

    def show(self, text: str) -> None:
        """Display a text without reporting an edit."""
        if self.text != text:
            with self.prevent(Input.Changed, Select.Changed, Checkbox.Changed):
                self.text = text

    @on(Input.Changed)
    @on(Select.Changed)
    @on(Checkbox.Changed)
    def _report_edit(self, event: Message) -> None:
        event.stop()
        # Send the current text: an older message must not undo a newer edit.
        self.post_message(FieldEdited(self.field.name, self.text))


class TextEditor(TextInput, Editor):
    """Edits a field as text; the up and down keys change a number by a step."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "step(1)", "Increase", show=False),
        Binding("down", "step(-1)", "Decrease", show=False),
        Binding("shift+up,ctrl+up", "step(1, True)", "Increase slightly", show=False),
        Binding("shift+down,ctrl+down", "step(-1, True)", "Decrease slightly", show=False),
    ]

    # The text of the session that was displayed last.
    _shown_text: str | None = None

    def refresh(
        self,
        *regions: Region,
        repaint: bool = True,
        layout: bool = False,  # noqa: ARG002
        recompose: bool = False,
    ) -> Self:
        """Redraw without a new layout, because the editor never changes its size."""
        return super().refresh(*regions, repaint=repaint, recompose=recompose)

    def check_consume_key(self, key: str, character: str | None) -> bool:
        """Whether a key types text; a question mark opens the help instead."""
        return character != "?" and super().check_consume_key(key, character)

    async def _on_key(self, event: Key) -> None:
        before, character = self.value[: min(self.selection)], event.character
        if event.is_printable and character and not self.field.accepts(before, character):
            # The base class would type the character.
            event.stop()
            event.prevent_default()
            self.post_message(TabKeyPressed(event.key))

    def action_step(self, direction: int, fine: bool = False) -> None:
        """Increase or decrease by a step."""
        self.post_message(FieldStepped(self.field.name, direction, fine))

    @on(Input.Submitted)
    def _focus_next(self, event: Input.Submitted) -> None:
        event.stop()
        self.screen.focus_next(TextEditor)

    def show(self, text: str) -> None:
        """Display a text of the session without reporting an edit; keep an edit it lacks."""
        if self.value == self._shown_text:
            super().show(text)
        if self.value == text:
            self._shown_text = text


class ChoiceEditor(Select[str], Editor):
    """Edits a field that has a fixed set of choices."""


class SeparationEditor(Checkbox, Editor):
    """A check box: whether the slider may leave the belt; labelled "considered" or "ignored"."""

    @property
    def text(self) -> str:
        """The displayed text."""
        return WITH_SEPARATION if self.value else WITHOUT_SEPARATION

    @text.setter
    def text(self, text: str) -> None:
        self.value = text == WITH_SEPARATION

    def watch_value(self) -> None:
        """Label the box."""
        self.label = self.text
        super().watch_value()


def editor_of(field: FormField, text: str) -> Editor:
    """The editor of a field, with its text."""
    editor: Editor
    if field.name == "separation":
        editor = SeparationEditor(text, value=text == WITH_SEPARATION, compact=True)
    elif field.choices is not None:
        choices = [(name, name) for name in field.choices]
        editor = ChoiceEditor(choices, value=text, allow_blank=False, compact=True)
    else:
        editor = TextEditor(
            text,
            replace_commas=field.replace_commas,
            compact=True,
            placeholder=field.when_empty,
            validate_on=(),
        )
    editor.field = field
    return editor
