"""The trajectory of a run while it goes on. Imports no Textual."""

from fivtui.transient.trajectory import Trajectory


class Growth:
    """Collects the parts that the computing thread hands out; another thread reads them."""

    def __init__(self) -> None:
        self._parts: list[Trajectory] = []
        self._read: list[Trajectory] | None = None
        self._count = 0
        self._joined: Trajectory | None = None

    def take(self, part: Trajectory) -> None:
        """Take the next part; one that does not go on after the last begins anew.

        Parameters
        ----------
        part : Trajectory
            Not empty.
        """
        if self._parts and part.t[0] <= self._parts[-1].t[-1]:
            self._parts = []
        self._parts.append(part)

    def trajectory(self) -> Trajectory | None:
        """All that is known by now.

        Returns
        -------
        Trajectory or None
            None before the first part.
        """
        parts = self._parts
        if parts is not self._read:
            self._read, self._count, self._joined = parts, 0, None
        new = parts[self._count :]
        if new:
            known = [] if self._joined is None else [self._joined]
            self._joined = Trajectory.joined([*known, *new])
            self._count += len(new)
        return self._joined
