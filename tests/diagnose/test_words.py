"""The verdict in words."""

from pa10d.diagnose.outcome.words import nothing


def test_noise_is_noise():
    said = nothing([0.1, 0.2, 0.3], [0.1, 0.19, 0.25], frozen=False)
    assert (
        said == "Nothing is missing: what the model leaves over on new data is measurement noise."
    )


def test_an_error_that_follows_nothing_is_owned_up_to():
    said = nothing([0.1, 0.5, 0.6], [0.1, 0.1, 0.2], frozen=True)
    assert said.startswith("Nothing has changed that this data can show. Joints 2 and 3 keep up")
    assert "5.0 times the noise" in said
    assert nothing([0.1, 0.5], [0.1, 0.1], frozen=False).count("Joint 2 keeps") == 1


def test_no_noise_floor_is_no_claim():
    assert "keep" not in nothing([0.1, 0.47], [float("nan"), 0.4], frozen=False)
    assert "keep" not in nothing([0.1, 0.47], [0.0, 0.4], frozen=False)
