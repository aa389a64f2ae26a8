"""The trajectory of a run in progress. Imports no Textual."""

from fivtui.transient import Trajectory


class PartialTrajectory:
    """Collects trajectory parts from the computing thread, for another thread to read."""

    def __init__(self) -> None:
        self._parts: list[Trajectory] = []
        self._read: list[Trajectory] | None = None
        self._count = 0
        self._joined: Trajectory | None = None

    def take(self, part: Trajectory) -> None:
        """Append a part; one that does not follow the last part starts over."""
        if self._parts and part.t[0] <= self._parts[-1].t[-1]:
            self._parts = []
        self._parts.append(part)

    def trajectory(self) -> Trajectory | None:
        """The trajectory so far; None before the first part."""
        parts = self._parts
        if parts is not self._read:
            self._read, self._count, self._joined = parts, 0, None
        new = parts[self._count :]
        if new:
            known = [] if self._joined is None else [self._joined]
            self._joined = Trajectory.joined([*known, *new])
            self._count += len(new)
        return self._joined
