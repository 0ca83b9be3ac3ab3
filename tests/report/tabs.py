"""A page in a browser, held against the runtime."""

from __future__ import annotations

import json
import random
import re
from pathlib import Path
from typing import Any

from mcpn.nets.game import TokenGame
from mcpn.nets.petri import PetriNet
from mcpn.robot.runtime import Controller


def opened(browser: Any, text: str, tmp_path: Path) -> tuple[Any, list[str]]:
    """A page in a browser without network, and what goes wrong in it."""
    (tmp_path / "report.html").write_text(text, encoding="utf-8")
    context = browser.new_context(offline=True)
    tab = context.new_page()
    tab.set_default_timeout(10_000)
    wrong: list[str] = []
    tab.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("dialog", lambda dialog: wrong.append(dialog.message))
    tab.on("request", lambda asked: None if asked.url.startswith("file:") else wrong.append(asked.url))
    tab.goto((tmp_path / "report.html").as_uri())
    return tab, wrong


def visited(browser: Any, address: str) -> tuple[Any, list[str]]:
    """A page that is served, and what goes wrong in it."""
    tab = browser.new_context().new_page()
    tab.set_default_timeout(30_000)
    wrong: list[str] = []
    tab.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.goto(address)
    return tab, wrong


def lit(tab: Any, selector: str, name: str) -> set[str]:
    found = tab.eval_on_selector_all(selector, f"parts => parts.map(part => part.dataset.{name})")
    return set(found)


def compare(tab: Any, runtime: Controller, boxes: dict[str, int]) -> None:
    """The page shows what the runtime says."""
    events = tab.eval_on_selector_all("#events button", "all => all.map(button => button.dataset.event)")
    assert sorted(events) == list(runtime.possible)
    state = runtime.state
    assert lit(tab, "rect[data-box].lit", "box") == {str(boxes[name]) for name in state.objectives}
    assert lit(tab, "rect[data-activity].lit", "activity") == set(state.mode)
    ways = tab.eval_on_selector_all(
        "text[data-alternative].lit", "parts => parts.map(p => [p.dataset.activity, p.dataset.alternative])"
    )
    assert {tuple(way) for way in ways} == set(state.mode.items())
    assert lit(tab, "rect[data-hardware].out", "hardware") == set(runtime.out_of_service)
    if runtime.outcome:
        assert runtime.outcome in tab.locator("#now").text_content()


def click(tab: Any, event: str) -> None:
    tab.locator(f'#events button[data-event="{event}"]').click()


def boxes_of(tab: Any) -> dict[str, int]:
    data: dict[str, int] = json.loads(tab.locator("#data").text_content())["boxes"]
    return data


def state(tab: Any) -> str:
    """What the page says that the robot does now."""
    text: str = tab.locator("#now").text_content()
    return text


def steps(tab: Any) -> list[str]:
    """The events of the film, as its address has them."""
    found: str = tab.evaluate("decodeURIComponent(location.hash)")
    return found.removeprefix("#run=").partition("&at=")[0].split(",") if found else []


def play_tokens(tab: Any, net: PetriNet, seed: int) -> None:
    """Fires at random, with ways back and forward, beside the definition of firing."""
    tab.locator("#game summary").click()
    game, draw = TokenGame(net), random.Random(seed)
    names = [place.name for place in net.places]
    for _ in range(40):
        tab.locator("#fired").filter(has_text=re.compile(rf"^{len(game.run)} fired")).wait_for()
        buttons = tab.locator("#enabled button")
        assert buttons.evaluate_all("all => all.map(one => Number(one.dataset.transition))") == game.enabled
        marked = [name for name, tokens in zip(names, game.marking, strict=True) if tokens]
        assert tab.locator("#marked").text_content() == ", ".join(marked)
        way = draw.choice(["fire"] * 6 * bool(game.enabled) + ["back", "forward", "settle"])
        if way == "fire":
            transition = draw.choice(game.enabled)
            game.fire(transition)
            tab.locator(f'#enabled [data-transition="{transition}"]').click()
            continue
        before = game.marking
        getattr(game, way)()
        if tab.locator(f"[data-game={way}]").is_disabled():
            assert game.marking == before
        else:
            tab.locator(f"[data-game={way}]").click()
    tab.locator("[data-game=restart]").click()
    assert tab.locator("#fired").text_content() == "0 fired."
