"""Headers of NPZ files: nested mappings and tables, without Python objects."""

import io
import json

import numpy as np

from fivtui.io import npz_format
from fivtui.model import Column


def test_a_nested_header_is_stored_without_objects_and_read_back() -> None:
    table = {"F": [[0.0, 80.0], [2.0, 100.0]], "mu": [[0.0, 0.7]]}
    nested = {"deviation": {"rms": 0.5, "max": 1.0}, "shift": None, "tolerances": [{"rms": 0.1}]}
    file = io.BytesIO()
    header = {"over_time": table, "validation": nested}
    npz_format.write(file, [Column("t", "s", "time")], {"t": np.arange(3.0)}, header)
    file.seek(0)
    stored = npz_format.header(file)
    assert stored["over_time"] == table
    assert stored["validation"]["deviation"] == nested["deviation"]
    # No array may hold Python objects: None is omitted, and a list of mappings becomes JSON text.
    assert "shift" not in stored["validation"]
    assert json.loads(stored["validation"]["tolerances"]) == nested["tolerances"]
