"""A guess before the answer: a number to choose, and what became of it."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

import ipywidgets as widgets

from meshfair.checks import check_choice, check_number, check_range
from meshfair.viewer.page import for_page
from meshfair.viewer.saved import Bundle, Displayed, Saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Answer(widgets.HTML):
    """What `Prediction.reveal` tells; a notebook gets it as HTML, which needs no kernel."""

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        return {"text/html": f"<p>{self.value}</p>"}, {}


class Prediction(Displayed, widgets.VBox):
    """A question whose answer is guessed first; `reveal` then tells how far off the guess is.

    The slider is the guess once it is confirmed. A notebook that runs without anybody to
    guess goes on without.

    Parameters
    ----------
    question : str
    ends : (float, float) or sequence of str
        The least and the largest number that can be guessed, or the words to choose from.
    unit : str
        Of the number.
    step : float
        The least that the slider moves.

    Attributes
    ----------
    guess : float, str or None
        None until the guess is confirmed. It can be set by code, too.

    Raises
    ------
    ValueError
        Ends that are no range, or a guess that is none of the choices.

    Examples
    --------
    >>> prediction = Prediction("After how many iterations?", (0, 30))  # doctest: +SKIP
    >>> prediction.reveal(2, "The shape goes, too.")                     # doctest: +SKIP
    """

    def __init__(
        self,
        question: str,
        ends: tuple[float, float] | tuple[str, ...],
        *,
        unit: str = "",
        step: float = 1,
    ) -> None:
        self.unit, self._guess, self._question = unit, None, question
        self._words = [end for end in ends if isinstance(end, str)]
        self._choice = " or ".join(self._words) if self._words else f"{ends[0]} to {ends[1]} {unit}"
        if self._words:
            self.control = widgets.ToggleButtons(options=self._words, value=None)
            self.control.style.button_width = "auto"
        else:
            low, high = check_range(ends, "ends")
            step = check_number(step, "step", 0, open_low=True)
            middle = low + step * round((high - low) / 2 / step)
            whole = all(float(number).is_integer() for number in (low, high, step))
            kind = widgets.IntSlider if whole else widgets.FloatSlider
            number = int if whole else float
            self.control = kind(
                value=number(middle),
                min=number(low),
                max=number(high),
                step=number(step),
                description=unit,
                style={"description_width": "initial"},
                layout={"width": "calc(100% - 8px)", "max_width": "34em"},
            )
        self.button = widgets.Button(
            description="That is my guess", layout={"width": "12em"}, tooltip="Confirm the guess"
        )
        self.answer = widgets.HTML()
        self.button.on_click(self._confirm)
        super().__init__(
            [
                widgets.HTML(f"<b>Your guess.</b> {html.escape(question)}"),
                widgets.HBox([self.control, self.button], layout={"flex_flow": "row wrap"}),
                self.answer,
            ]
        )
        self._saved = Saved(self, lambda: self._guess, self._kept, drawn="button")

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        """The question with its slider; in a page without a kernel, the question alone."""
        if for_page():
            return self._asked(), {}
        return super()._repr_mimebundle_(**kwargs)

    def _asked(self) -> Bundle:
        question = html.escape(f"{self._question} ({self._choice.strip()})")
        return {"text/html": f"<p><b>Your guess.</b> {question}</p>"}

    def _kept(self) -> Bundle:
        """What a notebook keeps: the question, and what was guessed."""
        told = f"<p>{self.answer.value}</p>" if self._guess is not None else ""
        return {"text/html": self._asked()["text/html"] + told, "text/plain": self._question}

    @property
    def guess(self) -> float | str | None:
        """What was guessed and confirmed."""
        return self._guess

    @guess.setter
    def guess(self, guess: float | str) -> None:
        if self._words:
            check_choice(guess, "guess", self._words)
        else:
            check_number(guess, "guess", self.control.min, self.control.max)
        self.control.value = guess
        self._confirm()

    def _confirm(self, _: widgets.Button | None = None) -> None:
        self._guess = self.control.value
        if self._guess is None:
            self.answer.value = "Choose one of them first."
        else:
            self.answer.value = f"You guess <b>{self._worded(self._guess)}</b>. Go on."
        self._saved.changed()

    def _worded(self, value: float | str) -> str:
        text = value if isinstance(value, str) else f"{value:.4g} {self.unit}"
        return html.escape(text.strip())

    def reveal(self, answer: float | str, why: str) -> widgets.HTML:
        """Tell the answer beside the guess.

        Parameters
        ----------
        answer : float or str
            What the computation gave.
        why : str
            The sentence that explains it.

        Returns
        -------
        ipywidgets.HTML
            To be the last value of a cell.
        """
        told = f"The answer is <b>{self._worded(answer)}</b>"
        if self._guess is None:
            told = told if for_page() else f"{told} (no guess was made above)"
        elif isinstance(answer, str) or isinstance(self._guess, str):
            told += f", you guessed {self._worded(self._guess)}"
        else:
            gap = abs(answer - self._guess)
            near = gap <= max(1.5 * self.control.step, 0.1 * abs(answer))
            how = "that is close" if near else f"{self._worded(gap)} off"
            told += f", you guessed {self._worded(self._guess)}: {how}"
        return Answer(f"{told}. {html.escape(why)}")

    def mark(self, axes: Axes, vertical: bool = True) -> None:
        """Draw the guess into a chart, if there is one.

        Parameters
        ----------
        axes : matplotlib.axes.Axes
        vertical : bool
            Whether the guess lies on the horizontal axis, so that its line is vertical.
        """
        if isinstance(self._guess, (int, float)):
            line = axes.axvline if vertical else axes.axhline
            line(self._guess, color="0.5", ls=":", label="your guess")
