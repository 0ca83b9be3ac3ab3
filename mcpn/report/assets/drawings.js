  // Drawings: larger and smaller.
  for (const frame of document.querySelectorAll(".frame")) {
    const shown = frame.querySelector(".drawing"), svg = shown.querySelector("svg");
    const natural = svg.viewBox.baseVal.width;
    let size = 1;
    const steps = {
      same: () => size, in: () => size * 1.25, out: () => size / 1.25, full: () => 1,
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
    // What is wider than the screen is made to fit, as far as it can then be read.
    const begin = () => {
      zoom("fit");
      if (size >= 0.55) return;
      size = 0.55;
      zoom("same");
      const first = svg.querySelector("[data-box]");  // as far from the left as there are routes back
      if (first) shown.scrollLeft = (first.getBBox().x - 100) * size;
    };
    if (Math.max(natural, svg.viewBox.baseVal.height) > 6000) {
      shown.classList.add("vast");
      shown.insertAdjacentHTML("afterend", '<p class="printed">The drawing is too large for paper: the page on a screen shows it.</p>');
    }
    if (details) details.addEventListener("toggle", () => { if (details.open && size === 1) zoom("fit"); });
    if (!details) begin(); else if (details.open) zoom("fit");
  }

