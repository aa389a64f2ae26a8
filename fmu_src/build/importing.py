"""The lock held while Python FMUs are imported, which changes tables that all threads share."""

import threading
from typing import Final

importing: Final = threading.Lock()
