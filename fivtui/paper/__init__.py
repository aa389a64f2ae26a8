"""The paper's figures and claims, computed from the model.

`families` says which scenes stand behind a figure, `study` computes them once for all that need
them, `export` writes them and `claims` holds the paper's statements against them.
"""
