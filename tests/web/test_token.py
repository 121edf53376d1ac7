"""A bench that wants a token."""

from __future__ import annotations

from benches import served


def test_the_page_asks_for_the_token_and_keeps_to_its_scope(browser, visit, tmp_path):
    tokens = tmp_path / "tokens.json"
    tokens.write_text('{"look": "seer", "command": "mover"}')
    with served(tmp_path, f"void-{tmp_path.name[:20]}", "--token-file", str(tokens)) as url:
        visitor = visit(url)
        page = visitor.page
        page.goto(url)
        page.get_by_label("Token").fill("wrong")
        page.get_by_role("button", name="Enter").click()
        page.get_by_text("That is not the token.").wait_for()
        page.get_by_label("Token").fill("seer")
        page.get_by_role("button", name="Enter").click()
        page.locator("#arm-state", has_text="offline").wait_for()
        page.get_by_role("button", name="Connect").click()
        page.locator(".notice.error", has_text="needs scope 'command'").wait_for()
        page.locator(".scope").first.wait_for(state="attached")  # sockets are let in, too
        page.reload()
        page.locator("#arm-state", has_text="offline").wait_for()
        assert not visitor.errors
