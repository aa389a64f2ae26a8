"""The paper's statements, each held against the model."""
