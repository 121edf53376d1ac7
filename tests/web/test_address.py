"""The address and the section belong together, whatever comes late."""

from __future__ import annotations

import pytest
from browsers import until


def kept(page, pattern: str) -> list:
    """The first request of this pattern waits here until somebody lets it go."""
    waiting: list = []
    page.route(pattern, lambda route: route.continue_() if waiting else waiting.append(route))
    return waiting


def until_kept(page, waiting: list) -> None:
    while not waiting:
        page.wait_for_timeout(20)


def test_an_answer_that_comes_late_leaves_the_user_in_the_section_gone_to(archive, visit):
    first = visit(archive[0])
    first.open("compare")
    first.page.locator("#compare-start:enabled").click()
    until(first.page, "location.hash.startsWith('#/compare/')")
    first.page.locator("#compare .ranked").wait_for()

    page = visit(archive[0]).page
    comparison = kept(page, "**/api/v1/comparisons/*")
    section = kept(page, "**/sections/diagnose.js")
    page.goto(f"{archive[0]}/#/compare")
    until_kept(page, comparison)
    page.evaluate("location.hash = '#/diagnose'")
    until_kept(page, section)
    comparison[0].continue_()
    page.locator("#compare .main-svg").first.wait_for(state="attached")
    section[0].continue_()
    page.locator("#diagnose h1").wait_for()
    assert page.evaluate("location.hash").startswith("#/diagnose")


def test_an_address_with_a_broken_escape_opens_the_page(archive, visit):
    page = visit(archive[0]).page
    page.goto(f"{archive[0]}/#/runs/%")
    page.locator("#runs h1").wait_for()
    assert page.locator("#notices article").count() == 0


@pytest.mark.long
def test_a_comparison_asked_for_is_not_replaced_by_one_that_opens_by_itself(archive, visit):
    """Whoever comes back finds the newest one; whoever presses meanwhile gets what was asked."""
    first = visit(archive[0])
    first.open("compare")
    first.page.locator("#compare-start:enabled").click()
    first.page.locator("#compare .ranked").wait_for()

    page = visit(archive[0]).page
    earlier = kept(page, "**/api/v1/comparisons/*")
    page.goto(f"{archive[0]}/#/compare")
    until_kept(page, earlier)
    page.locator("#compare-start:enabled").click()
    page.locator("#compare .ranked").wait_for()
    address = page.evaluate("location.hash")
    page.evaluate("document.querySelector('#compare .ranked').dataset.mine = 'yes'")
    earlier[0].continue_()
    page.wait_for_timeout(500)
    assert page.evaluate("location.hash") == address
    assert page.locator("#compare .ranked[data-mine=yes]").count() == 1


@pytest.mark.parametrize(
    ("address", "section", "said"),
    [
        *(
            pytest.param(*more, marks=pytest.mark.long)
            for more in (
                ("models/nope", "models", "This model cannot be shown. model 'nope': none of"),
                ("runs/nope", "runs", "This run cannot be shown. run 'nope': none of this name"),
                (
                    "investigate/nope",
                    "investigate",
                    "This investigation cannot be shown. investigation",
                ),
            )
        ),
        ("foo", "robot", "This section cannot be shown. The page has no section 'foo'"),
    ],
)
def test_an_address_of_what_is_not_there_says_so(archive, visit, address, section, said):
    """It showed another thing without a word: at first sight, and gone to later."""
    visitor = visit(archive[0])
    page = visitor.page
    page.goto(f"{archive[0]}/#/{address}")
    message = page.locator("#notices article, #notices .notice", has_text=said)
    message.wait_for()
    page.locator(f"#{section} h1").wait_for()
    message.get_by_label("Close this message").click()
    page.evaluate("location.hash = '#/compare'")
    page.locator("#compare h1").wait_for()
    page.evaluate(f"location.hash = '#/{address}'")
    message.wait_for()
    assert not page.evaluate("location.hash").endswith("nope")
    assert not visitor.errors


def test_the_skip_link_leaves_one_where_one_is(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    visitor.page.evaluate("location.hash = '#content'")
    visitor.page.wait_for_timeout(300)
    assert visitor.page.locator("#models h1").is_visible()
    assert visitor.page.locator("#notices .notice").count() == 0
