  // Robot: the page follows one that runs, event by event (mcpn/editor/served.py).
  const follows = byId("robot-follows");
  if (follows) {
    const came = [], told = byId("robot-told"), journal = new EventSource("stream");
    let refused = 0, shown = 0, lost = "";
    const tell = (how) => {
      told.textContent = `${how}: ${came.length} events${refused ? `, ${refused} refused` : ""}.${lost}`;
    };
    // Who clicks, plays or goes back looks at something else than what the robot does.
    const strayed = () => film.length !== shown || place !== shown;
    follows.addEventListener("change", () => {
      if (!follows.checked) return;
      load(came);
      shown = film.length;
      show();
    });
    journal.addEventListener("message", (line) => {
      const step = JSON.parse(line.data);
      if (strayed()) follows.checked = false;
      if (step.refused) {
        refused += 1;
      } else {
        came.push(step.event);
        if (follows.checked) {
          move(step.event);
          shown = film.length;
          show();
        }
      }
      tell("The robot runs");
    });
    journal.addEventListener("lost", (line) => {
      lost = ` ${JSON.parse(line.data)}`;
      tell("The robot runs");
    });
    journal.addEventListener("end", (line) => {
      journal.close();
      const outcome = JSON.parse(line.data);
      tell(outcome ? `The robot has ended in ${outcome}` : "The robot was stopped");
    });
    journal.addEventListener("error", () => tell("mcpn run does not answer"));
    begin();
    show();
    tell("The robot runs");
  }
