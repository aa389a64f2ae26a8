"""``python -m fivtui.tui`` starts the terminal UI."""

from .start import run

if __name__ == "__main__":
    run()
