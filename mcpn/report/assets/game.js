  // --- the token game: the net, transition by transition (mcpn/net/game.py) ------------------------------------
  const board = byId("game");
  if (board && data.net) {
    const { places, initial, transitions, priorities } = data.net;
    const pairs = (flat) => flat.flatMap((place, i) => (i % 2 ? [] : [[place, flat[i + 1]]]));
    const moves = transitions.map(([name, event, rank, consume, produce, read]) =>
      ({ name, event, rank, consume: pairs(consume), produce: pairs(produce), read: pairs(read) }));
    let marking = [...initial];
    const fired = [], undone = [];
    const covers = (move) => [...move.consume, ...move.read].every(([place, weight]) => marking[place] >= weight);
    const enabled = () => {
      const found = [...moves.keys()].filter((t) => covers(moves[t]));
      const least = Math.min(...found.map((t) => moves[t].rank));
      return priorities ? found.filter((t) => moves[t].rank === least) : found;
    };
    const fire = (t) => {
      fired.push([marking, t]);
      marking = [...marking];
      for (const [place, weight] of moves[t].consume) marking[place] -= weight;
      for (const [place, weight] of moves[t].produce) marking[place] += weight;
    };
    const MOST_FIRED = 10_000, SHOWN = 12;
    const does = {
      back: () => { if (fired.length) { undone.push(fired.at(-1)[1]); [marking] = fired.pop(); } },
      forward: () => { if (undone.length) fire(undone.pop()); },
      settle: () => {
        for (let count = 0; count < MOST_FIRED; count++) {
          const first = enabled()[0];
          if (first === undefined || moves[first].event) break;
          undone.length = 0;
          fire(first);
        }
      },
      restart: () => { while (fired.length) does.back(); },
    };
    const told = (arcs) => arcs.map(([place, weight]) => (weight > 1 ? `${weight} ` : "") + places[place]).join(" + ");
    const shownGame = () => {
      const marked = places.flatMap((name, i) =>
        (marking[i] ? [marking[i] > 1 ? `${marking[i]} ${name}` : name] : []));
      byId("marked").textContent = marked.join(", ") || "nothing";
      byId("enabled").replaceChildren(...enabled().map((t) => {
        const move = moves[t], button = make("button", move.event && move.event !== move.name ? `${move.name} [${move.event}]` : move.name);
        button.type = "button";
        button.dataset.transition = t;
        button.title = `${told(move.consume)}${move.read.length ? `, reads ${told(move.read)}` : ""} → ${told(move.produce)}`;
        button.className = move.event ? "" : "internal";
        button.addEventListener("click", () => { undone.length = 0; fire(t); shownGame(); });
        return button;
      }));
      byId("fired").textContent = `${fired.length} fired${fired.length ? ", the last: " : "."}`
        + fired.slice(-SHOWN).map(([, t]) => moves[t].name).join(", ");
      for (const button of board.querySelectorAll("[data-game]")) {
        const key = button.dataset.game;
        button.disabled = key === "forward" ? !undone.length : key === "settle" ? false : !fired.length;
      }
    };
    for (const button of board.querySelectorAll("[data-game]")) {
      button.addEventListener("click", () => { does[button.dataset.game](); shownGame(); });
    }
    shownGame();
  }

