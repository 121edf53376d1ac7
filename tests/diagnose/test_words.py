"""The verdict in words."""

from pa10d.diagnose.outcome.words import nothing


def test_noise_is_noise():
    said = nothing([0.1, 0.2, 0.3], [0.1, 0.19, 0.25], frozen=False)
    assert (
        said == "Nothing is missing: what the model leaves over on new data is measurement noise."
    )


def test_what_only_a_new_fit_took_away_is_said_too():
    """The noise of the refitted model is no praise of the one that was given."""
    said = nothing([0.1, 0.2], [0.1, 0.2], frozen=False, as_given=[0.14, 0.2])
    assert "as it was given, it keeps up to 1.4 times the noise on joint 1" in said
    assert nothing([0.1], [0.1], False, as_given=[0.11]) == nothing([0.1], [0.1], False)
    assert "given" not in nothing([0.1], [float("nan")], False, as_given=[0.3])


def test_what_reversals_leave_is_said_where_they_are_left_out():
    """Friction of low speeds may hide there: 25 N·m beside 60 were called nothing."""
    said = nothing([0.1, 0.2], [0.1, 0.2], False, with_reversals=[0.24, 0.2])
    assert "with them, there is up to 2.4 times the noise on joint 1:" in said
    assert nothing([0.1], [0.1], False, with_reversals=[0.11]) == nothing([0.1], [0.1], False)


def test_an_error_that_follows_nothing_is_owned_up_to():
    said = nothing([0.1, 0.5, 0.6], [0.1, 0.1, 0.2], frozen=True)
    assert said.startswith("Nothing has changed that this data can show. Joints 2 and 3 keep up")
    assert "5.0 times the noise" in said
    assert nothing([0.1, 0.5], [0.1, 0.1], frozen=False).count("Joint 2 keeps") == 1


def test_no_noise_floor_is_no_claim():
    assert "keep" not in nothing([0.1, 0.47], [float("nan"), 0.4], frozen=False)
    assert "keep" not in nothing([0.1, 0.47], [0.0, 0.4], frozen=False)
