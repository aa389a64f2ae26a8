"""The two ways in which a request can fail, and cancellation."""


class InputError(ValueError):
    """The request itself is wrong: one line saying what, where and what is allowed."""


class ComputationError(RuntimeError):
    """A computation that cannot finish.

    Parameters
    ----------
    why : str
        What stopped the computation, with the time at which it happened where there is one.
    advice : str
        What to try instead.
    """

    def __init__(self, why: str, advice: str) -> None:
        super().__init__(why, advice)
        self.why = why
        self.advice = advice

    def __str__(self) -> str:
        return f"{self.why}; {self.advice}"


class Cancelled(Exception):
    """The progress callback asked for the computation to stop."""
