"use strict";
(() => {
  // Names are keys: an object that inherits nothing has no other ones, such as "constructor".
  const bare = (key, value) =>
    value && typeof value === "object" && !Array.isArray(value) ? Object.assign(Object.create(null), value) : value;
  const data = JSON.parse(document.getElementById("data").textContent, bare);

  // --- tables: sorted by a click on a head, filtered by what is typed -------------------------------------
  const order = new Intl.Collator(undefined, { numeric: true });
  for (const table of document.querySelectorAll("table")) {
    const body = table.tBodies[0], rows = [...body.rows];
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const text = (row) => row.cells[column].textContent;
      rows.sort((a, b) => order.compare(text(a), text(b)) * (down ? -1 : 1));
      body.append(...rows);
    }));
    const section = table.closest("section");
    section.querySelector("input").addEventListener("input", (typed) => {
      const words = typed.target.value.toLowerCase().split(/\s+/);
      let count = 0;
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        row.hidden = !words.every((word) => text.includes(word));
        count += !row.hidden;
      }
      section.querySelector(".count").textContent = `${count} of ${rows.length}`;
    });
  }

  // --- drawings: larger and smaller -----------------------------------------------------------------------
  for (const frame of document.querySelectorAll(".frame")) {
    const shown = frame.querySelector(".drawing"), svg = shown.querySelector("svg");
    const natural = svg.viewBox.baseVal.width;
    let size = 1;
    const steps = {
      in: () => size * 1.25, out: () => size / 1.25, full: () => 1,
      fit: () => Math.min(1, (shown.clientWidth - 4) / natural),
    };
    const zoom = (step) => {
      size = Math.min(4, Math.max(0.05, steps[step]()));
      svg.style.width = `${natural * size}px`;
      svg.style.height = "auto";
    };
    for (const button of frame.querySelectorAll("[data-zoom]")) {
      button.addEventListener("click", () => zoom(button.dataset.zoom));
    }
    shown.addEventListener("keydown", (key) => {
      const step = { "+": "in", "-": "out", 0: "full" }[key.key];
      if (step) zoom(step);
    });
    const details = frame.closest("details");
    if (details) {
      details.addEventListener("toggle", () => { if (details.open && size === 1) zoom("fit"); });
      if (details.open) zoom("fit");
    }
  }
  if (!data.controller) return;

  // --- the controller, as mcpn/controller/targets/json.py describes it ------------------------------------
  const machine = data.controller;
  const START = "MISSION_EV_START", ENDS = new Map([["succeed", "success"], ["fail", "failure"], ["abort", "abort"]]);
  const sections = new Map(machine.sections.map((section) => [section.name, section]));
  for (const type of machine.types) {
    type.moves = type.states.map(() => new Map());
    for (const edge of type.edges) {
      const moves = type.moves[edge.from];
      if (!moves.has(edge.event)) moves.set(edge.event, []);
      moves.get(edge.event).push(edge);
    }
  }
  const typeOf = (section) => machine.types[section.type];
  const named = (section, kind, name) => section.names[kind]?.[name] ?? name;
  const way = (section, activity, alternative) => {
    const whole = named(section, "alternatives", `${activity}.${alternative}`);
    const dot = whole.indexOf(".");
    return [whole.slice(0, dot), whole.slice(dot + 1)];
  };
  const action = (section, told) => {
    if (told.do === "select") return `select ${way(section, told.activity, told.alternative).join(": ")}`;
    if (told.do === "release") return `release ${named(section, "hardware", told.hardware)}`;
    if (told.activity === undefined) return `${told.do} ${named(section, "objectives", told.objective)}`;
    return `${told.do} ${named(section, "activities", told.activity)}`;
  };
  const first = { phase: "before", section: null, at: 0, out: new Set(machine.out_of_service || []), happened: new Set() };
  const lasting = new Set(machine.unrepairable || []);
  const handlers = (section, names) => (names || []).map((name) => named(section, "once", name));
  /** Of edges by one event the one that can be taken: some ask whether handlers have happened. */
  const allowed = (state, edges) => (edges || []).find((edge) =>
    handlers(state.section, edge.open).every((name) => !state.happened.has(name))
    && handlers(state.section, edge.happened).every((name) => state.happened.has(name)));

  function enter(state, route) {
    if (ENDS.has(route)) return [{ ...state, phase: ENDS.get(route), section: null, at: 0 }, []];
    const section = sections.get(route), type = typeOf(section);
    let number = 0;
    type.hardware.forEach((name, bit) => {
      if (state.out.has(named(section, "hardware", name))) number += 2 ** bit;
    });
    const entry = type.entries[number];
    if (!entry) throw new Error(`${route} cannot be entered`);
    const actions = entry.actions.map((told) => action(section, told));
    return [{ ...state, phase: "running", section, at: entry.to }, actions];
  }

  const hardwareOf = (event) => {
    for (const [ending, fails] of [["_EV_OOS", true], ["_EV_RD", false]]) {
      const name = event.slice(0, -ending.length);
      if (event.endsWith(ending) && machine.hardware.includes(name)) return [name, fails];
    }
    return [null, false];
  };

  /** The state after an event and the actions, or null where it cannot be taken. */
  function take(state, event) {
    const [hardware, fails] = hardwareOf(event);
    let next = state;
    if (hardware) {
      const out = new Set(state.out);
      if (fails) out.add(hardware); else out.delete(hardware);
      next = { ...state, out };
    }
    const number = state.section ? state.section.events.indexOf(event) : -1;
    if (number >= 0) {
      const edge = allowed(state, typeOf(state.section).moves[state.at].get(number));
      if (!edge) return null;
      next = { ...next, happened: new Set([...state.happened, ...handlers(state.section, edge.open)]) };
      const actions = edge.actions.map((told) => action(state.section, told));
      if (typeof edge.to === "number") return [{ ...next, at: edge.to }, actions];
      const [entered, more] = enter(next, state.section.routes[edge.to]);
      return [entered, actions.concat(more)];
    }
    if (hardware) return state.out.has(hardware) === fails || (!fails && lasting.has(hardware)) ? null : [next, []];
    return event === START && state.phase === "before" ? enter(next, machine.initial) : null;
  }

  function possible(state) {
    const found = new Set(state.phase === "before" ? [START] : []), covered = new Set();
    if (state.section) {
      const type = typeOf(state.section);
      for (const [number, edges] of type.moves[state.at]) {
        if (allowed(state, edges)) found.add(state.section.events[number]);
      }
      for (const name of type.hardware) covered.add(named(state.section, "hardware", name));
    }
    for (const name of machine.hardware) {
      const out = state.out.has(name);
      if (!covered.has(name) && !(out && lasting.has(name))) found.add(name + (out ? "_EV_RD" : "_EV_OOS"));
    }
    return [...found].sort();
  }

  // --- what the page shows of it --------------------------------------------------------------------------
  const byId = (id) => document.getElementById(id);
  const make = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });
  const drawing = document.querySelector(".drawing");
  const parts = [...drawing.querySelectorAll("[data-box], [data-activity], [data-hardware]")];
  const past = [];
  let state = first;

  function inside() {
    const { section, at } = state;
    if (!section) return { objectives: [], mode: new Map(), waiting: [], refused: [] };
    const told = typeOf(section).states[at];
    const pairs = (mode) => Object.entries(mode).map(([activity, name]) => way(section, activity, name));
    return {
      objectives: told.objectives.map((name) => named(section, "objectives", name)),
      mode: new Map(pairs(told.mode)),
      waiting: pairs(told.waiting).map(([activity]) => activity),
      refused: told.refused.map((name) => named(section, "activities", name)),
    };
  }

  function sentence(told) {
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

  function light(told) {
    const running = new Set(told.objectives.map((name) => String(data.boxes[name])));
    let shown = null;
    for (const part of parts) {
      const { box, within, activity, alternative, hardware } = part.dataset;
      let lit;
      if (box !== undefined) lit = running.has(box) && (within === undefined || told.mode.has(within));
      else if (alternative !== undefined) lit = told.mode.get(activity) === alternative;
      else if (activity !== undefined) lit = told.mode.has(activity);
      else part.classList.toggle("out", state.out.has(hardware));
      part.classList.toggle("lit", Boolean(lit));
      if (lit && box !== undefined && within === undefined) shown ??= part;
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

  const KINDS = [["The mission", ["start"]], ["Objectives", ["success", "failure"]],
    ["Declared events", ["declared", "named"]], ["Hardware", ["out of service", "repaired", "lost"]]];

  function show() {
    const told = inside();
    byId("now").textContent = sentence(told);
    byId("undo").disabled = byId("restart").disabled = !past.length;
    const groups = byId("events"), events = possible(state);
    groups.replaceChildren();
    for (const [heading, kinds] of KINDS) {
      const some = events.filter((event) => kinds.includes(data.events[event][0]));
      if (some.length) groups.append(make("h4", heading));
      for (const event of some) {
        const button = make("button", data.events[event][1]);
        button.type = "button";
        button.dataset.event = button.title = event;
        button.addEventListener("click", () => go(event));
        groups.append(button);
      }
    }
    byId("history").replaceChildren(...past.map((step) => {
      const item = make("li", data.events[step.event][1]);
      if (step.actions.length) item.append(make("small", step.actions.join("; ")));
      return item;
    }));
    light(told);
  }

  function move(event) {
    const found = take(state, event);
    if (!found) return false;
    past.push({ event, before: state, actions: found[1] });
    state = found[0];
    return true;
  }
  function go(event) {
    if (!move(event)) return;
    show();
    const again = byId("events").querySelector("button");
    if (again) again.focus({ preventScroll: true });
  }
  function undo() {
    const step = past.pop();
    if (step) { state = step.before; show(); }
  }
  function restart() { past.length = 0; state = first; show(); }

  byId("undo").addEventListener("click", undo);
  byId("restart").addEventListener("click", restart);
  document.addEventListener("keydown", (key) => {
    if (key.target instanceof HTMLInputElement || key.ctrlKey || key.metaKey || key.altKey) return;
    if (key.key === "u") undo();
    if (key.key === "r") restart();
  });
  for (const button of document.querySelectorAll(".replay")) {
    button.addEventListener("click", () => {
      past.length = 0;
      state = first;
      JSON.parse(button.dataset.events).every(move);
      show();
      byId("controller").scrollIntoView({ block: "nearest" });
    });
  }
  byId("journal").addEventListener("change", async (change) => {
    const [file] = change.target.files;
    if (!file) return;
    const lines = (await file.text()).split("\n");
    past.length = 0;
    state = first;
    byId("replayed").textContent = replay(lines) || `${past.length} events replayed.`;
    show();
  });
  // What the runtime has written, a JSON object a line; says what is wrong with it.
  function replay(lines) {
    for (const [index, line] of lines.entries()) {
      if (!line.trim()) continue;
      let event, refused;
      try {
        ({ event, refused } = JSON.parse(line));
      } catch {
        return `Line ${index + 1} is no line of a journal.`;
      }
      if (typeof event !== "string" || typeof refused !== "boolean") return `Line ${index + 1} holds no event.`;
      if (refused ? take(state, event) : !move(event)) {
        return `Line ${index + 1}: ${event} is ${refused ? "" : "not "}possible here.`;
      }
    }
    return "";
  }
  show();
})();
