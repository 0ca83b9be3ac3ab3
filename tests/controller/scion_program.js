// SCION as a program: events in, one a line; out what is logged, and the active states. Needs @scion-scxml/scxml.
"use strict";
const fs = require("fs");
const scxml = require("@scion-scxml/scxml");

scxml.documentStringToModel(process.argv[2], fs.readFileSync(process.argv[2], "utf8"), (error, model) => {
  if (error) throw error;
  model.prepare((failed, prepared) => {
    if (failed) throw failed;
    let logged = [];
    const sink = { log: (label) => logged.push(String(label)), warn() {}, error() {}, info() {} };
    const begin = () => {
      const chart = new scxml.core.Statechart(prepared, { console: sink });
      chart.start();
      return chart;
    };
    let chart = begin();
    for (const event of fs.readFileSync(0, "utf8").split("\n").slice(0, -1)) {
      if (event === "") {
        chart = begin();
        continue;
      }
      logged = [];
      chart.gen({ name: event });
      process.stdout.write(JSON.stringify([logged, chart.getConfiguration().sort()]) + "\n");
    }
    process.exit(0);
  });
});
