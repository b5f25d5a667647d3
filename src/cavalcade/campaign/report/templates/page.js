"use strict";
(() => {
  const { columns, rows } = JSON.parse(document.getElementById("data").textContent);
  const table = document.getElementById("all");
  const more = document.getElementById("more");
  const search = document.getElementById("search");
  const failed = document.getElementById("failed");
  const STEP = 100;
  const at = Object.fromEntries(columns.map(([name], k) => [name, k]));
  const texts = rows.map((row) => row.join(" ").toLowerCase());
  const isFailure = (row) => row[at.feasible] === "yes" && row[at.success] !== "yes";
  let sorted = null; // column and direction
  let limit = STEP;

  const head = document.createElement("tr");
  columns.forEach(([name, digits], k) => {
    const cell = document.createElement("th");
    const button = document.createElement("button");
    cell.scope = "col";
    if (digits !== null) cell.className = "number";
    button.type = "button";
    button.textContent = name;
    button.addEventListener("click", () => {
      sorted = { column: k, up: sorted && sorted.column === k ? !sorted.up : true };
      draw();
    });
    cell.append(button);
    head.append(cell);
  });
  table.tHead.append(head);

  // Missing values come last whichever way the column is sorted.
  const compare = (a, b) => {
    if (a === null || b === null) return (a === null) - (b === null);
    const order = typeof a === "number" ? a - b : String(a).localeCompare(String(b));
    return sorted.up ? order : -order;
  };

  function draw() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let found = rows.filter((row, k) =>
      words.every((word) => texts[k].includes(word)) && (!failed.checked || isFailure(row)));
    if (sorted) found = found.slice().sort((a, b) => compare(a[sorted.column], b[sorted.column]));
    const body = document.createElement("tbody");
    for (const row of found.slice(0, limit)) {
      const line = document.createElement("tr");
      line.className = row[at.success] === "yes" ? "ok" : isFailure(row) ? "failed" : "";
      row.forEach((value, k) => {
        const cell = document.createElement("td");
        const [name, digits] = columns[k];
        const text = digits === null ? value : value?.toFixed(digits);
        cell.textContent = text ?? "–";
        cell.className = digits === null ? name : "number";
        line.append(cell);
      });
      body.append(line);
    }
    table.tBodies[0].replaceWith(body);
    [...head.children].forEach((cell, k) => {
      const mine = sorted && sorted.column === k;
      cell.ariaSort = mine ? (sorted.up ? "ascending" : "descending") : "none";
      cell.firstChild.textContent = columns[k][0] + (mine ? (sorted.up ? " ↑" : " ↓") : "");
    });
    const shown = Math.min(limit, found.length);
    document.getElementById("shown").textContent = `${shown} of ${found.length} shown`;
    more.hidden = found.length <= limit;
  }

  const again = () => { limit = STEP; draw(); };
  search.addEventListener("input", again);
  failed.addEventListener("change", again);
  more.addEventListener("click", () => { limit += 10 * STEP; draw(); });
  draw();
})();
