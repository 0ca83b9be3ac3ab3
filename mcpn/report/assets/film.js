  // The film: steps taken so far and those that follow, of which the page shows one place.
  const drawing = document.querySelector(".drawing");
  const parts = [...drawing.querySelectorAll("[data-box], [data-activity], [data-hardware]")];
  const film = [];
  let place = 0, playing = null;
  const stateAt = (at) => (at ? film[at - 1].after : first);
  const current = () => stateAt(place);

  function sentence(state, told) {
    if (state.phase === "before") return "The mission has not begun.";
    if (state.phase !== "running") return `The mission has ended in ${state.phase}.`;
    const said = [`Running: ${told.objectives.join(", ") || "nothing yet"}.`];
    const ways = [...told.mode].filter(([activity, name]) => activity !== name);
    if (ways.length) said.push(`With ${ways.map((pair) => pair.join(": ")).join(", ")}.`);
    if (told.refused.length) said.push(`No way to run: ${told.refused.join(", ")}.`);
    if (told.waiting.length) said.push(`Waiting: ${told.waiting.join(", ")}.`);
    if (state.out.size) said.push(`Out of service: ${[...state.out].sort().join(", ")}.`);
    return said.join(" ");
  }

  /** Boxes of objectives that have run so far, by how the last of them ended. */
  function path() {
    const found = new Map();
    for (const step of film.slice(0, place)) {
      for (const name of step.running) found.set(String(data.boxes[name]), "been");
      const ended = /^OBJ_(.*)_EV_(OK|FAIL|TIMEOUT)$/.exec(step.event);
      if (ended) found.set(String(data.boxes[ended[1]]), ended[2] === "OK" ? "succeeded" : "failed");
    }
    return found;
  }

  function light(state, told) {
    const running = new Set(told.objectives.map((name) => String(data.boxes[name]))), been = path();
    let shown = null;
    for (const part of parts) {
      const { box, within, activity, alternative, hardware } = part.dataset;
      let lit;
      if (box !== undefined) lit = running.has(box) && (within === undefined || told.mode.has(within));
      else if (alternative !== undefined) lit = told.mode.get(activity) === alternative;
      else if (activity !== undefined) lit = told.mode.has(activity);
      else part.classList.toggle("out", state.out.has(hardware));
      part.classList.toggle("lit", Boolean(lit));
      if (box !== undefined && within === undefined) {
        part.classList.remove("been", "succeeded", "failed");
        if (been.has(box)) part.classList.add("been", been.get(box));
        if (lit) shown ??= part;
      }
    }
    if (shown) {
      const here = shown.getBoundingClientRect(), frame = drawing.getBoundingClientRect();
      if (here.top < frame.top || here.bottom > frame.bottom) {
        drawing.scrollTop += here.top - frame.top - frame.height / 3;
      }
      if (here.left < frame.left || here.right > frame.right) {
        drawing.scrollLeft += here.left - frame.left - frame.width / 3;
      }
    }
  }

  const KINDS = [["The mission", ["start"]], ["Objectives", ["success", "failure", "timeout"]],
    ["Declared events", ["declared", "named"]], ["Hardware", ["out of service", "repaired", "lost"]]];
  const HARDWARE = KINDS.length - 1;
  let tallest = 0;

  /** Buttons for what may happen; those of hardware stay where they are. */
  function offer(state) {
    const events = possible(state), above = make("div", ""), below = make("div", "");
    for (const [number, [heading, kinds]] of KINDS.entries()) {
      const group = number === HARDWARE ? below : above;
      const some = events.filter((event) => kinds.includes(data.events[event][0]));
      if (some.length) group.append(make("h4", heading));
      for (const event of some) {
        const button = make("button", data.events[event][1]);
        button.type = "button";
        button.dataset.event = button.title = event;
        button.addEventListener("click", () => go(event));
        group.append(button);
      }
    }
    byId("events").replaceChildren(above, below);
    tallest = Math.max(tallest, above.offsetHeight);
    above.style.minHeight = `${tallest}px`;
  }

  function show() {
    const state = current(), told = inside(state);
    byId("now").textContent = sentence(state, told);
    byId("undo").disabled = byId("restart").disabled = !place;
    byId("step").disabled = byId("end").disabled = place === film.length;
    byId("play").textContent = playing ? "pause" : "play";
    Object.assign(byId("slider"), { max: film.length, value: place });
    byId("place").textContent = `${place} of ${film.length}`;
    offer(state);
    byId("history").replaceChildren(...film.map((step, number) => {
      const item = make("li", data.events[step.event][1]);
      if (number >= place) item.className = "ahead";
      if (number === place - 1) item.setAttribute("aria-current", "step");
      if (step.actions.length) item.append(make("small", step.actions.join("; ")));
      return item;
    }));
    light(state, told);
    address();
  }

  /** Takes an event; what followed in the film is forgotten. */
  function move(event) {
    const before = current(), found = take(before, event);
    if (!found) return false;
    film.length = place;
    film.push({ event, actions: found[1], after: found[0], running: inside(found[0]).objectives });
    place += 1;
    return true;
  }
  function go(event) {
    pause();
    const kind = document.activeElement?.dataset?.event && hardwareOf(event)[0];
    if (!move(event)) return;
    show();
    const again = [...byId("events").querySelectorAll("button")];
    (again.find((button) => kind && hardwareOf(button.dataset.event)[0] === kind) || again[0])
      ?.focus({ preventScroll: true });
  }
  function seek(to) {
    place = Math.max(0, Math.min(film.length, to));
    show();
  }
  function pause() {
    clearInterval(playing);
    playing = null;
  }
  function begin() {
    pause();
    film.length = place = 0;
  }
  function load(events) {
    begin();
    const whole = events.every(move);
    return whole;
  }
  const EVERY = 900;
  function play() {
    if (playing) { pause(); show(); return; }
    if (!film.length) load(JSON.parse(document.querySelector(".replay")?.dataset.events || "[]"));
    if (!film.length) return;
    if (place === film.length) place = 0;
    playing = setInterval(() => {
      if (place + 1 >= film.length) pause();
      seek(place + 1);
    }, EVERY);
    show();
  }
  /** Events at random, by their weights, until the mission ends. */
  const MOST_BY_CHANCE = 500;
  function chance() {
    pause();
    if (current().phase !== "before" && current().phase !== "running") place = 0;
    for (let count = 0; count < MOST_BY_CHANCE && ["before", "running"].includes(current().phase); count++) {
      const events = possible(current());
      const weights = events.map((event) => data.events[event][2]);
      let left = Math.random() * weights.reduce((sum, weight) => sum + weight, 0);
      const drawn = events.find((_, i) => (left -= weights[i]) < 0) ?? events[events.length - 1];
      if (drawn === undefined || !move(drawn)) break;
    }
    show();
  }

  /** The address shows the state: a link leads to it. */
  const RUN = "#run=";
  function address() {
    const run = film.map((step) => encodeURIComponent(step.event)).join(",");
    const hash = run && RUN + run + (place < film.length ? `&at=${place}` : "");
    if (!run && !location.hash.startsWith(RUN)) return;
    history.replaceState(null, "", hash || location.pathname + location.search);
  }
  function follow() {
    if (!location.hash.startsWith(RUN)) return;
    const [run, at] = location.hash.slice(RUN.length).split("&at=");
    let events;
    try {
      events = run.split(",").map(decodeURIComponent);
    } catch {
      events = [];
    }
    const whole = load(events);
    byId("replayed").textContent = whole ? "" : "The address says a run that is not possible here.";
    if (at !== undefined) place = Math.max(0, Math.min(film.length, Number.parseInt(at, 10) || 0));
    show();
  }
  addEventListener("hashchange", follow);

  const KEYS = new Map([["u", () => seek(place - 1)], ["ArrowLeft", () => seek(place - 1)],
    ["ArrowRight", () => seek(place + 1)], ["r", () => { pause(); seek(0); }], ["Home", () => seek(0)],
    ["End", () => { pause(); seek(film.length); }], [" ", play], ["c", chance]]);
  for (const [id, does] of [["restart", "r"], ["undo", "u"], ["step", "ArrowRight"], ["end", "End"],
    ["play", " "], ["chance", "c"]]) {
    byId(id).addEventListener("click", KEYS.get(does));
  }
  byId("slider").addEventListener("input", (moved) => { pause(); seek(Number(moved.target.value)); });
  document.addEventListener("keydown", (key) => {
    if (key.target instanceof HTMLInputElement || key.ctrlKey || key.metaKey || key.altKey) return;
    // Keys that scroll or press something do that where there is something to scroll or press.
    if (key.key.length > 1 && key.target.closest(".drawing, .wide, aside")) return;
    if (key.key === " " && key.target.closest("button, summary, a")) return;
    const does = KEYS.get(key.key);
    if (!does) return;
    if (key.key.length > 1 && !film.length) { // no run is loaded yet: they move in the one that the page tells
      const told = document.querySelector(".replay")?.dataset.events;
      if (!told) return;
      load(JSON.parse(told));
      place = 0;
    }
    if (key.key === " " || key.key.length > 1) key.preventDefault();
    does();
  });
  document.addEventListener("click", (clicked) => {
    const button = clicked.target.closest(".replay");
    if (!button) return;
    load(JSON.parse(button.dataset.events));
    if (button.dataset.from === "start") { place = 0; play(); } else show();
    byId("controller").scrollIntoView({ block: "nearest" });
  });
  byId("lose")?.addEventListener("click", () => {
    begin();
    for (const tick of byId("lost").querySelectorAll("input:checked")) move(`${tick.value}_EV_OOS`);
    move(START);
    show();
    byId("controller").scrollIntoView({ block: "nearest" });
  });
  byId("journal").addEventListener("change", async (change) => {
    const [file] = change.target.files;
    if (!file) return;
    const lines = (await file.text()).split("\n");
    begin();
    byId("replayed").textContent = replay(lines) || `${film.length} events replayed.`;
    show();
  });
  // What the runtime has written, a JSON object a line; says what is wrong with it.
  function replay(lines) {
    for (const [index, line] of lines.entries()) {
      if (!line.trim()) continue;
      let event, refused, resumed;
      try {
        ({ event, refused, resumed } = JSON.parse(line));
      } catch {
        return `Line ${index + 1} is no line of a journal.`;
      }
      if (event === undefined && typeof resumed === "number") continue; // the run was resumed here
      if (typeof event !== "string" || typeof refused !== "boolean") return `Line ${index + 1} holds no event.`;
      if (refused ? take(current(), event) : !move(event)) {
        return `Line ${index + 1}: ${event} is ${refused ? "" : "not "}possible here.`;
      }
    }
    return "";
  }
  if (location.hash.startsWith(RUN)) follow(); else show();
