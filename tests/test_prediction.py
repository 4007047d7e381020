"""A guess before the answer."""

import pytest

explorers = pytest.importorskip("meshfair.explorers", reason="needs the notebooks extra")
pyplot = pytest.importorskip("matplotlib.figure", reason="needs the viewer extra")


def test_a_number_is_confirmed_and_compared():
    prediction = explorers.Prediction("How many <b>?", (0, 30), unit="iterations")
    assert prediction.guess is None
    assert "&lt;b&gt;?" in prediction.children[0].value
    prediction.control.value = 12
    assert prediction.guess is None  # moved, not yet confirmed
    prediction.button.click()
    assert prediction.guess == 12
    told = prediction.reveal(2, "The shape goes, too.").value
    assert told == (
        "The answer is <b>2 iterations</b>, you guessed 12 iterations: 10 iterations off. "
        "The shape goes, too."
    )
    prediction.guess = 3
    assert "that is close" in prediction.reveal(2, "").value


def test_words_to_choose_from():
    prediction = explorers.Prediction("Which weights?", ("combinatorial", "cotangent"))
    prediction.button.click()
    assert prediction.guess is None
    assert "Choose one" in prediction.answer.value
    prediction.guess = "cotangent"
    assert "you guessed cotangent" in prediction.reveal("combinatorial", "So.").value
    with pytest.raises(ValueError, match="guess is 'cotan'; give one of combinatorial, cotangent"):
        prediction.guess = "cotan"


def test_without_a_guess_the_answer_comes_all_the_same():
    prediction = explorers.Prediction("How large?", (0.0, 1.0), step=0.05)
    assert "(no guess was made above). Because." in prediction.reveal(0.3, "Because.").value
    axes = pyplot.Figure().add_subplot()
    prediction.mark(axes)
    assert not axes.lines
    prediction.guess = 0.35
    prediction.mark(axes)
    assert list(axes.lines[0].get_xdata()) == [0.35, 0.35]
    with pytest.raises(ValueError, match="guess is 2; give a number of at least 0 and at most 1"):
        prediction.guess = 2


@pytest.mark.parametrize("ends", [(3, 1), (0, float("nan")), 7])
def test_ends_that_are_no_range(ends):
    with pytest.raises((ValueError, TypeError)):
        explorers.Prediction("How many?", ends)
