"""Starts the terminal UI on whatever Textual is connected to: ``python -m fivtui.tui``."""

from .start import run

if __name__ == "__main__":
    run()
