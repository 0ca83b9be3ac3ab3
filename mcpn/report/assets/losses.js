  // What if: hardware that is lost from the start, read off the minimal cut sets.
  const lostParts = byId("lost");
  if (lostParts && data.losses) {
    const { mission, safety, objectives } = data.losses;
    const ticks = [...lostParts.querySelectorAll("input")];
    const told = () => {
      const lost = new Set(ticks.filter((tick) => tick.checked).map((tick) => tick.value));
      const by = (sets) => sets.find((set) => set.every((name) => lost.has(name)));
      const found = [], left = (sets) => sets
        .map((set) => set.filter((name) => !lost.has(name))).sort((a, b) => a.length - b.length);
      const words = (set) => set.length ? set.join(" and ") : "nothing at all";
      const cut = by(mission);
      if (!lost.size) found.push(["note", "Nothing is lost: tick what is."]);
      else if (cut) found.push(["fails", `The mission cannot succeed without ${words(cut)}.`]);
      else {
        const next = left(mission)[0];
        found.push(["holds", `The mission can still succeed${next ? `; the next loss that defeats it: ${words(next)}` : ""}.`]);
      }
      if (lost.size && safety) {
        const unsafe = by(safety);
        found.push(unsafe ? ["fails", `It cannot end safely, in success or abort, without ${words(unsafe)}.`]
          : ["holds", "It can still end safely, in success or abort."]);
      }
      const gone = objectives.filter(([, sets]) => by(sets)).map(([names]) => names);
      if (lost.size && gone.length) found.push(["note", `These objectives cannot succeed: ${gone.join(", ")}.`]);
      byId("loses").replaceChildren(...found.map(([state, text]) =>
        Object.assign(make("li", text), { className: state })));
      for (const row of document.querySelectorAll("tr[data-needs]")) {
        const impossible = JSON.parse(row.dataset.needs).some((name) => lost.has(name));
        row.classList.toggle("gone", impossible);
        row.title = impossible ? "not possible with what is lost" : "";
      }
    };
    lostParts.addEventListener("change", told);
    told();
  }

