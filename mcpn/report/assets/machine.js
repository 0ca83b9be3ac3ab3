  if (!data.controller) return;

  // The controller, as mcpn/controller/document.py describes it.
  const machine = data.controller;
  const START = "MISSION_EV_START", ENDS = new Map([["succeed", "success"], ["fail", "failure"], ["abort", "abort"]]);
  const sections = new Map(machine.sections.map((section) => [section.name, section]));
  const named = (section, kind, name) => section.names[kind]?.[name] ?? name;

  // Both forms are asked alike: entry, move, possible and shown; handlers and facts are told by number.

  /** A table of states and edges. */
  function tableOf(type, once, facts) {
    const moves = type.states.map(() => new Map()), number = new Map(once.map((name, i) => [name, i]));
    const those = (names) => (names || []).map((name) => number.get(name));
    const said = (to) => ({ ...to, gained: those(to.gained), lost: those(to.lost) });
    for (const edge of type.edges) {
      const of = moves[edge.from], open = those(edge.open), happened = those(edge.happened), told = said(edge);
      if (!of.has(edge.event)) of.set(edge.event, []);
      of.get(edge.event).push({ ...told, open, happened, gained: [...open, ...told.gained] });
    }
    const move = (at, event, true_) => (moves[at].get(event) || []).find((edge) =>
      edge.open.every((i) => !true_.has(i)) && edge.happened.every((i) => true_.has(i)));
    return {
      entry(gone, true_) {
        let bits = 0;
        for (const i of gone) bits += 2 ** i;
        const first = type.hardware.length, handlers = once.length - facts;
        for (let i = 0; i < (type.entering || 0); i++) if (true_.has(handlers + i)) bits += 2 ** (first + i);
        return type.entries[bits] && said(type.entries[bits]);
      },
      move,
      possible: (at, true_) => [...moves[at].keys()].filter((event) => move(at, event, true_)),
      shown: (at) => type.states[at],
    };
  }

  /** Rules on bits, which are those of one number. */
  function rulesOf(type, once, facts) {
    const mask = (bits) => [...new Set(bits)].reduce((all, bit) => all | 1n << BigInt(bit), 0n);
    const asked = (literals) => {
      const of = mask(literals.map((l) => l >> 1)), value = mask(literals.filter((l) => l & 1).map((l) => l >> 1));
      return (at) => (at & of) === value;
    };
    const status = type.status.map((one) => [mask(one.changes), asked([one.when])]);
    const ofOnce = status.slice(type.hardware.length);
    const effects = type.effects.map((one) => ({ ...one, changes: mask(one.changes) }));
    const rules = type.events.map(() => []), rule = (one) => [asked(one.if), effects[one.do]];
    const parts = type.parts.map((part) => part.map(rule));
    for (const one of type.rules) rules[one.event].push(rule(one));
    const entries = type.entries.map(rule);
    const shown = type.shown.map((one) => [one.kind, one.name, asked([one.when])]);
    const taken = (fitting, at) => {
      const found = fitting.find(([fits]) => fits(at));
      if (!found) return null;
      let after = at ^ found[1].changes, to = found[1].to;
      const actions = [...found[1].actions], gained = [], lost = [];
      for (const part of found[1].then) { // literals from the number of bits on ask for what has been made so far
        const both = at | after << BigInt(type.bits), taken = parts[part].find(([fits]) => fits(both));
        if (!taken) continue;
        after ^= taken[1].changes;
        actions.push(...taken[1].actions);
        to ??= taken[1].to;
      }
      ofOnce.forEach(([, when], i) => {
        if (when(after)) gained.push(i); else if (i >= once.length - facts) lost.push(i);
      });
      return { to: to ?? after, actions, gained, lost };
    };
    return {
      entry(gone, true_) {
        let at = mask(type.idle);
        for (const i of gone) at ^= status[i][0];
        for (const i of true_) at ^= ofOnce[i][0];
        return taken(entries, at);
      },
      move: (at, event) => taken(rules[event], at),
      possible: (at) => [...rules.keys()].filter((event) => rules[event].some(([fits]) => fits(at))),
      shown(at) {
        const lists = { objectives: [], refused: [], mode: [], waiting: [] };
        for (const [kind, name, when] of shown) if (kind in lists && when(at)) lists[kind].push(name);
        return lists;
      },
    };
  }

  for (const type of machine.types) {
    const facts = type.facts || [];
    type.once = [...(type.once || []), ...facts];
    type.does = (type.rules ? rulesOf : tableOf)(type, type.once, facts.length);
  }
  const typeOf = (section) => machine.types[section.type];
  const onceOf = (section) => typeOf(section).once.map((name) =>
    section.names.once?.[name] ?? section.names.facts?.[name] ?? name);
  const numbers = (names, some) => new Set([...names.keys()].filter((i) => some.has(names[i])));
  const hardwareIn = (section) => typeOf(section).hardware.map((name) => named(section, "hardware", name));
  const way = (section, whole) => {
    const own = named(section, "alternatives", whole), dot = own.indexOf(".");
    return [own.slice(0, dot), own.slice(dot + 1)];
  };
  const order = (section, told) => {
    if (told.do === "select") return `select ${way(section, `${told.activity}.${told.alternative}`).join(": ")}`;
    if (told.do === "release") return `release ${named(section, "hardware", told.hardware)}`;
    if (told.activity === undefined) return `${told.do} ${named(section, "objectives", told.objective)}`;
    return `${told.do} ${named(section, "activities", told.activity)}`;
  };
  const first = { phase: "before", section: null, at: 0, out: new Set(machine.out_of_service || []), happened: new Set() };
  const lasting = new Set(machine.unrepairable || []), crashing = new Set(machine.crashing || []);
  // By hardware that is detected late, what is true while it is out of service and that is known.
  const late = new Map(Object.entries(machine.late || {}));
  for (const [name, known] of late) if (first.out.has(name)) first.happened.add(known);
  /** Whether hardware that the section does not use may fail, or be repaired where it is out of service. */
  const changes = (state, name) => state.out.has(name)
    ? !lasting.has(name) && (!late.has(name) || state.happened.has(late.get(name))) : !crashing.has(name);
  const truth = (state) => numbers(onceOf(state.section), state.happened);
  /** What has happened, and is true of facts, after a step of a section. */
  function happened(state, section, step) {
    const names = onceOf(section), now = new Set(state.happened);
    for (const i of step.gained) now.add(names[i]);
    for (const i of step.lost) now.delete(names[i]);
    return now;
  }

  function enter(state, route) {
    if (ENDS.has(route)) return [{ ...state, phase: ENDS.get(route), section: null, at: 0 }, []];
    const section = sections.get(route), gone = numbers(hardwareIn(section), state.out);
    const entry = typeOf(section).does.entry(gone, numbers(onceOf(section), state.happened));
    if (!entry) throw new Error(`${route} cannot be entered`);
    const actions = entry.actions.map((told) => order(section, told));
    const now = happened(state, section, entry);
    return [{ ...state, phase: "running", section, at: entry.to, happened: now }, actions];
  }

  const hardwareOf = (event) => {
    for (const [ending, fails] of [["_EV_OOS", true], ["_EV_RD", false]]) {
      const name = event.slice(0, -ending.length);
      if (event.endsWith(ending) && machine.hardware.includes(name)) return [name, fails];
    }
    return [null, false];
  };
  const changing = machine.changing || Object.create(null);
  /** What is true of facts after an event that changes some beside a section, or null where nothing changes. */
  function changed(state, event) {
    const now = new Set([...state.happened, ...changing[event].true]);
    for (const name of changing[event].false) now.delete(name);
    return now.size === state.happened.size && [...now].every((name) => state.happened.has(name)) ? null : now;
  }

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
      const step = typeOf(state.section).does.move(state.at, number, truth(state));
      if (!step) return null;
      next = { ...next, happened: happened(next, state.section, step) };
      const actions = step.actions.map((told) => order(state.section, told));
      if (typeof step.to !== "string") return [{ ...next, at: step.to }, actions];
      const [entered, more] = enter(next, state.section.routes[step.to]);
      return [entered, actions.concat(more)];
    }
    if (hardware) {
      if (state.out.has(hardware) === fails || !changes(state, hardware)) return null;
      const now = new Set(next.happened);
      if (!fails) now.delete(late.get(hardware));
      return [{ ...next, happened: now }, []];
    }
    if (event in changing) {
      const now = changed(state, event);
      return now && [{ ...state, happened: now }, []];
    }
    return event === START && state.phase === "before" ? enter(next, machine.initial) : null;
  }

  function possible(state) {
    const found = new Set(state.phase === "before" ? [START] : []), covered = new Set();
    if (state.section) {
      const { does } = typeOf(state.section);
      for (const number of does.possible(state.at, truth(state))) found.add(state.section.events[number]);
      for (const name of hardwareIn(state.section)) covered.add(name);
    }
    for (const name of machine.hardware) {
      const out = state.out.has(name);
      if (!covered.has(name) && changes(state, name)) found.add(name + (out ? "_EV_RD" : "_EV_OOS"));
    }
    for (const event of Object.keys(changing)) {
      if (!state.section?.events.includes(event) && changed(state, event)) found.add(event);
    }
    // An objective's success stands before its failure.
    const key = (event) => event.replace(/_EV_OK$/, "_EV_");
    return [...found].sort((a, b) => (key(a) < key(b) ? -1 : 1));
  }

  /** What runs in a state. */
  function inside({ section, at }) {
    if (!section) return { objectives: [], mode: new Map(), waiting: [], refused: [] };
    const told = typeOf(section).does.shown(at);
    const pairs = (mode) => (Array.isArray(mode) ? mode : Object.entries(mode).map((pair) => pair.join(".")))
      .map((whole) => way(section, whole));
    return {
      objectives: told.objectives.map((name) => named(section, "objectives", name)),
      mode: new Map(pairs(told.mode)),
      waiting: pairs(told.waiting).map(([activity]) => activity),
      refused: told.refused.map((name) => named(section, "activities", name)),
    };
  }

