  // Tables: sorted by a click on a head, filtered by what is typed.
  const collator = new Intl.Collator(undefined, { numeric: true });
  for (const table of document.querySelectorAll("table")) {
    const body = table.tBodies[0], rows = [...body.rows];
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const text = (row) => row.cells[column].textContent;
      rows.sort((a, b) => collator.compare(text(a), text(b)) * (down ? -1 : 1));
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

