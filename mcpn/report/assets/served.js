  // Served: the page follows the files of the mission, and asks what is typed.
  const posted = async (to, question) => {
    try {
      return await (await fetch(to, {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(question),
      })).json();
    } catch {
      return { error: "no answer: mcpn serve has ended" };
    }
  };
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
    const said = (text, className) => Object.assign(make("p", text), { className });
    const supposing = byId("suppose"), orders = [...document.querySelectorAll("#suppose fieldset")].map((set) =>
      [set.dataset.activity, set.querySelector("ol"), [...set.querySelectorAll("li")]]);
    supposing?.addEventListener("click", (clicked) => {
      const item = clicked.target.closest("button[type=button]")?.closest("li");
      if (item?.previousElementSibling) {
        item.previousElementSibling.before(item);
        item.querySelector("button").focus();
      }
    });
    supposing?.addEventListener("reset", () => {
      for (const [, list, items] of orders) list.replaceChildren(...items);
      byId("supposed").replaceChildren();
    });
    supposing?.addEventListener("submit", async (asked) => {
      asked.preventDefault();
      const told = byId("supposed"), ways = Object.create(null);
      for (const [activity, list] of orders) {
        ways[activity] = [...list.querySelectorAll("input:checked")].map((tick) => tick.value);
      }
      const lost = [...document.querySelectorAll("#lost input:checked")].map((tick) => tick.value);
      told.replaceChildren(said("…", ""));
      const answer = await posted("suppose", { lost, ways });
      if (answer.error !== undefined) {
        told.replaceChildren(said(answer.error, "missing"));
        return;
      }
      const table = make("table", ""), head = make("tr", "");
      head.append(...["", "as it is", "so"].map((text) => Object.assign(make("th", text), { scope: "col" })));
      table.append(head);
      for (const { asked: question, said: both } of answer.rows) {
        const row = make("tr", "");
        row.append(Object.assign(make("th", question), { scope: "row" }), ...both.map(([state, text]) => said(text, state)).map((p) => {
          const cell = make("td", "");
          cell.append(p);
          return cell;
        }));
        row.classList.toggle("other", both[0][1] !== both[1][1]);
        table.append(row);
      }
      const wide = Object.assign(make("div", ""), { className: "wide" });
      wide.append(table);
      const same = answer.rows.every(({ said: both }) => both[0][1] === both[1][1]);
      told.replaceChildren(said(same ? "Nothing that this page says first would be other." :
        "What would be other has a mark.", "reading"), wide);
      if (answer.left_out.length) {
        told.append(said(`Not asked so, for they speak of an alternative that is taken away: ${answer.left_out.join(", ")}.`, "reading"));
      }
    });
    byId("ask")?.addEventListener("submit", async (asked) => {
      asked.preventDefault();
      const formula = byId("formula").value, told = byId("answered");
      told.replaceChildren(make("p", "…"));
      const answer = await posted("ask", { formula });
      if (answer.error !== undefined) {
        told.replaceChildren(said(answer.error, "missing"));
        return;
      }
      const run = make("ol", "");
      for (const [event, words] of answer.steps) {
        const item = make("li", `${words} `);
        item.append(make("code", event));
        run.append(item);
      }
      const [mark, state] = answer.holds ? ["✓ holds", "holds"] : ["✗ fails", "fails"];
      told.replaceChildren(said(`${mark}: ${answer.formula}`, state), run, ...answer.notes.map((note) => make("p", note)));
      if (answer.steps.length && data.controller) {
        const again = make("button", "Replay this run");
        again.type = "button";
        again.className = "replay";
        again.dataset.events = JSON.stringify(answer.steps.map(([event]) => event));
        told.append(again);
      }
    });
  }

