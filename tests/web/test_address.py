"""The address and the section belong together, whatever comes late."""

from __future__ import annotations

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
