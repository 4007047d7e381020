"""What a check found, and what that is worth."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Graded:
    """What a check returns that gives a part of its points."""

    share: float
    """0 to 1 of the points."""
    hint: str = ""
    expected: str = ""
    got: str = ""
    metric: float | None = None
    """A figure for the leaderboard; larger is better."""


@dataclass(frozen=True)
class Outcome:
    """What one check found."""

    task: str
    title: str
    points: float
    earned: float
    status: str
    """right, partly, wrong or not done."""
    hint: str = ""
    expected: str = ""
    got: str = ""
    metric: float | None = None
    note: str = ""
    """On which functions of the file this was marked, where not on the student's own alone."""
