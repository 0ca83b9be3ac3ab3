  // The token game: a walk of the net's graph, in the page or the server's (mcpn/report/pages/token_game.py).
  const board = byId("game");
  if (board && data.net) {
    const { transitions, positions, first: begun } = data.net;
    const stored = ([marked, firings]) => ({
      marked,
      enabled: firings.flatMap((t, i) => (i % 2 ? [] : [[t, ...transitions[t]]])),
      to: new Map(firings.flatMap((t, i) => (i % 2 ? [] : [[t, firings[i + 1]]]))),
    });
    let here = positions ? stored(positions[0]) : begun, busy = false;
    const fired = [], undone = [];
    const next = async (t) => (positions ? stored(positions[here.to.get(t)])
      : posted("fire", { tokens: here.tokens, transition: t }));
    /** Whether a transition has fired; the server may have gone. */
    const fire = async (t) => {
      const after = await next(t);
      byId("game-told").textContent = after.error ?? "";
      if (after.error !== undefined) return false;
      fired.push([here, t, here.enabled.find(([number]) => number === t)[1]]);
      here = after;
      return true;
    };
    const MOST_FIRED = 1_000, SHOWN = 12;
    const does = {
      back: () => { if (fired.length) { undone.push(fired.at(-1)[1]); [here] = fired.pop(); } },
      forward: async () => { if (undone.length && await fire(undone.at(-1))) undone.pop(); },
      settle: async () => {
        for (let count = 0; count < MOST_FIRED && here.enabled.length && !here.enabled[0][2]; count++) {
          undone.length = 0;
          if (!await fire(here.enabled[0][0])) break;
        }
      },
      restart: () => { while (fired.length) does.back(); },
    };
    const shownGame = () => {
      byId("marked").textContent = here.marked || "nothing";
      byId("enabled").replaceChildren(...here.enabled.map(([t, name, event, arcs]) => {
        const button = make("button", event && event !== name ? `${name} [${event}]` : name);
        button.type = "button";
        button.dataset.transition = t;
        button.title = arcs;
        button.className = event ? "" : "internal";
        button.addEventListener("click", () => played(async () => { undone.length = 0; await fire(t); }));
        return button;
      }));
      byId("fired").textContent = `${fired.length} fired${fired.length ? ", the last: " : "."}`
        + fired.slice(-SHOWN).map(([, , name]) => name).join(", ");
      for (const button of board.querySelectorAll("[data-game]")) {
        const key = button.dataset.game;
        button.disabled = key === "forward" ? !undone.length : key === "settle" ? false : !fired.length;
      }
    };
    /** One move after the other: what is asked of a server comes later. */
    const played = async (move) => {
      if (busy) return;
      busy = true;
      try {
        await move();
      } finally {
        busy = false;
        shownGame();
      }
    };
    for (const button of board.querySelectorAll("[data-game]")) {
      button.addEventListener("click", () => played(does[button.dataset.game]));
    }
    shownGame();
  }

