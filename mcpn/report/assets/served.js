  // --- served: the page follows the files of the mission, and asks what is typed -----------------------------
  const served = byId("served");
  if (served) {
    const following = setInterval(async () => {
      let told;
      try {
        told = await (await fetch("number")).json();
      } catch {
        byId("served-told").textContent = "mcpn serve has ended: what is shown stays.";
        clearInterval(following);
        return;
      }
      if (String(told.number) !== served.dataset.number) {
        clearInterval(following);
        location.reload();
      }
    }, 700);
    byId("ask")?.addEventListener("submit", async (asked) => {
      asked.preventDefault();
      const formula = byId("formula").value, told = byId("answered");
      told.replaceChildren(make("p", "…"));
      let answer;
      try {
        answer = await (await fetch("ask", {
          method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ formula }),
        })).json();
      } catch {
        answer = { error: "no answer: mcpn serve has ended" };
      }
      if (answer.error !== undefined) {
        told.replaceChildren(Object.assign(make("p", answer.error), { className: "missing" }));
        return;
      }
      const run = make("ol", "");
      for (const [event, words] of answer.steps) {
        const item = make("li", `${words} `);
        item.append(make("code", event));
        run.append(item);
      }
      const said = make("p", `${answer.holds ? "✓ holds" : "✗ fails"}: ${answer.formula}`);
      said.className = answer.holds ? "holds" : "fails";
      told.replaceChildren(said, run, ...answer.notes.map((note) => make("p", note)));
      if (answer.steps.length && data.controller) {
        const again = make("button", "Replay this run");
        again.type = "button";
        again.className = "replay";
        again.dataset.events = JSON.stringify(answer.steps.map(([event]) => event));
        told.append(again);
      }
    });
  }

