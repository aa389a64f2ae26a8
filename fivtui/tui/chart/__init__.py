"""Charts in characters: axes, traces, drawing."""
