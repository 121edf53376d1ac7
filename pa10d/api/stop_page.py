"""What a browser shows after STOP was pressed before the page's script was there, or without it."""

from __future__ import annotations

from fastapi.responses import HTMLResponse

PATH = "/api/v1/robot/stop-page"

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="color-scheme" content="light dark">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title></head>
<body style="font: 20px/1.5 sans-serif; margin: 2em"><h1>{title}</h1>
<p>{text}</p>
{again}<p><a href="/">Back to the page</a></p>
</body></html>
"""
_AGAIN = """<form method="post"><button style="font: inherit; font-weight: 700; color: #fff;
background: #c8102e; padding: 10px 30px">STOP</button></form>"""


def heard(state: str, at_rest: bool) -> HTMLResponse:
    """state: of the arm, as control said it last."""
    advice = "" if at_rest else " If the arm moves, press the hardware emergency stop."
    text = f"The arm is {state}.{advice}"
    return HTMLResponse(_PAGE.format(title="Stop was heard", text=text, again=_AGAIN))


def not_heard() -> HTMLResponse:
    """A plain form has no token to send, so that none is offered."""
    text = (
        "Press the hardware emergency stop. This daemon obeys who shows a token, and only the "
        "page's script can: go back, wait until the page is whole, and press Stop there."
    )
    page = _PAGE.format(title="STOP WAS NOT HEARD", text=text, again="")
    return HTMLResponse(page, status_code=401)
