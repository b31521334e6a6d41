"use strict";
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const panel = document.getElementById("panel");
  const stage = document.getElementById("stage"), policy = document.getElementById("policy");
  const cells = new Map(), places = new Map(), nodes = new Map();
  const key = (s, p, c) => s + "/" + p + "/" + c;
  for (const one of data.cells) {
    cells.set(key(one.s, one.p, one.c), one);
    if (one.place) places.set(key(one.s, one.p, one.place.join(",")), one);
  }

  const make = (tag, text, name) => {
    const node = document.createElement(tag);
    if (text !== undefined) node.textContent = text;
    if (name) node.className = name;
    return node;
  };
  const percent = (share) => (share === null ? "–" : +(100 * share).toFixed(1) + " %");
  const number = (value) => (value === null || value === undefined ? "–" : String(value).replace("-", "−"));
  const quantity = (value, unit) => number(value) + (unit === "°" ? "°" : unit ? " " + unit : "");
  const where = (one) => data.axes.map((axis, k) => axis.label + " " + quantity(one.at[k], axis.unit)).join(", ");
  const label = (one) => {
    const by = data.names.indexOf(one.by);
    return one.v + (one.v === "beyond" && by >= 0 ? ": " + data.limits[by].label : "");
  };

  // Outlines of the cell under the pointer or the keyboard, and of the one in the panel.
  const outlined = {};
  function outline(node, name) {
    for (const old of outlined[name] || []) old.remove();
    outlined[name] = [];
    const path = node && node.querySelector("path");
    if (!path) return;
    for (const kind of ["halo", "ring" + (name === "chosen" ? " chosen" : "")]) {
      const copy = document.createElementNS("http://www.w3.org/2000/svg", "path");
      copy.setAttribute("d", path.getAttribute("d"));
      copy.setAttribute("class", kind);
      node.ownerSVGElement.appendChild(copy);
      outlined[name].push(copy);
    }
  }

  function table(heads, rows, name) {
    const scroll = make("div", undefined, "scroll"), grid = make("table", undefined, name);
    const head = grid.appendChild(make("thead")).appendChild(make("tr"));
    for (const text of heads) head.appendChild(make("th", text));
    const body = grid.appendChild(make("tbody"));
    for (const row of rows) {
      const line = body.appendChild(make("tr", undefined, row.over ? "over" : ""));
      for (const text of row.texts) line.appendChild(make("td", text));
    }
    scroll.appendChild(grid);
    return scroll;
  }

  function limits(one) {
    const rows = data.limits.map((limit, k) => ({
      over: one.by === data.names[k],
      texts: [limit.label, limit.value, number(one.by_limit[k]), one.use[k] === null ? "–" : percent(one.use[k])],
    }));
    return table(["limit", "at", "episodes beyond", "95th percentile of the use"], rows, "limits");
  }

  function episodes(one) {
    const rows = one.rows.map((row) => ({
      over: row[4].length > 0,
      texts: [
        row[0], row[2] < 0 ? "–" : data.reasons[row[2]].replaceAll("_", " ") + (row[3] ? "" : " ✘"),
        row[4].map((k) => (typeof k === "number" ? data.limits[k].label : k)).join("; ") || "none",
        ...row.slice(5).map(number),
      ],
    }));
    return table(["seed", "outcome", "exceeded", "time [s]", ...data.peaks], rows, "episodes");
  }

  function film(one) {
    if (!one.film) {
      const box = make("div");
      box.append(make("p", "No film of this cell in this page. This makes one of its worst episode:"),
        make("pre", data.commands[one.s][one.p] + one.c));
      return box;
    }
    const button = make("button", "Show the film of this cell");
    button.type = "button";
    button.addEventListener("click", () => {
      const shown = make("video");
      shown.controls = shown.muted = shown.autoplay = true;
      shown.src = document.getElementById(one.film).src;
      button.replaceWith(shown);
    });
    return button;
  }

  // The same cell in the other stages and with the other policies.
  function others(one) {
    const line = make("p");
    for (const [s, p] of data.stages.flatMap((_, s) => data.policies.map((_, p) => [s, p]))) {
      const other = cells.get(key(s, p, one.c));
      if (!other || (s === one.s && p === one.p) || (s !== one.s && p !== one.p)) continue;
      const button = make("button", (s === one.s ? data.policies[p] : data.stages[s]) + ": " + other.v);
      button.type = "button";
      button.addEventListener("click", () => {
        if (stage.value !== "") stage.value = s;
        if (policy.value !== "") policy.value = p;
        choose();
        open(other);
      });
      line.append(button, " ");
    }
    if (line.childNodes.length) line.prepend("The same cell – ");
    return line;
  }

  function open(one) {
    panel.replaceChildren();
    const close = make("button", "Close", "close");
    close.type = "button";
    close.addEventListener("click", shut);
    panel.append(close, make("h3", data.stages[one.s] + " with " + data.policies[one.p] + ", cell " + one.c),
      make("p", where(one)), make("p", label(one), "verdict"),
      make("p", percent(one.share[0]) + " of " + one.n + " episodes beyond a limit (" + number(one.over) +
        "), interval " + percent(one.share[1]) + " to " + percent(one.share[2]) + "."));
    if (!one.valid) panel.append(make("p", "Outside the validity of the seaway's model.", "over"));
    if (one.worst !== null) panel.append(make("p", "Greatest use of a limit: " + percent(one.worst) + "."));
    panel.append(others(one), limits(one), film(one));
    panel.append(make("h3", one.rows.length < one.n
      ? "The " + one.rows.length + " worst of " + one.n + " episodes" : "All " + one.n + " episodes, the worst first"));
    if (one.rows.length) panel.append(episodes(one));
    else panel.append(make("p", "The page holds no episodes of this cell."));
    panel.hidden = false;
    panel.scrollTop = 0;
    document.body.classList.add("opened");
    outline(nodes.get(one), "chosen");
  }

  function shut() {
    panel.hidden = true;
    document.body.classList.remove("opened");
    const back = outlined.chosen && outlined.chosen.length && [...nodes.values()].find((node) => node.tabIndex === 0);
    outline(null, "chosen");
    if (back) back.focus();
  }

  // One cell of each figure can be reached by Tab; the arrow keys go on from there.
  function reach(one) {
    for (const [other, node] of nodes) {
      if (other.s === one.s && other.p === one.p) node.setAttribute("tabindex", other === one ? "0" : "-1");
    }
  }

  function step(one, event) {
    const steps = { ArrowRight: [0, 1, 0], ArrowLeft: [0, -1, 0], ArrowUp: [0, 0, 1], ArrowDown: [0, 0, -1],
      PageDown: [1, 0, 0], PageUp: [-1, 0, 0] };
    const by = steps[event.key];
    if (!by) return;
    event.preventDefault();
    let place = one.place;
    for (let tries = 0; tries < Math.max(...data.sizes); tries++) { // over cells without data
      place = place.map((at, k) => at + by[k]);
      if (data.closed) place[1] = (place[1] + data.sizes[1]) % data.sizes[1];
      const next = places.get(key(one.s, one.p, place.join(",")));
      if (next && nodes.has(next)) {
        reach(next);
        nodes.get(next).focus();
        return;
      }
    }
  }

  function prepare(node) {
    const found = /s(\d+)p(\d+)c(-?\d+)$/.exec(node.id);
    const one = found && cells.get(key(found[1], found[2], found[3]));
    if (!one) return;
    const first = ![...nodes.keys()].some((other) => other.s === one.s && other.p === one.p);
    nodes.set(one, node);
    node.classList.add("cell");
    node.setAttribute("role", "button");
    node.setAttribute("tabindex", first ? "0" : "-1");
    const told = where(one) + ": " + label(one) + ", " + percent(one.share[0]) + " of " + one.n + " episodes";
    node.setAttribute("aria-label", told);
    node.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "title")).textContent = told;
    node.addEventListener("click", () => { reach(one); open(one); });
    node.addEventListener("focus", () => outline(node, "focus"));
    node.addEventListener("blur", () => outline(null, "focus"));
    node.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") {
        event.preventDefault();
        open(one);
      } else if (event.key === "Escape") shut();
      else step(one, event);
    });
  }

  function choose() {
    for (const plate of document.querySelectorAll(".plate")) {
      const out = (stage.value !== "" && plate.dataset.stage !== stage.value) ||
        (policy.value !== "" && plate.dataset.policy !== policy.value);
      plate.classList.toggle("out", out);
    }
  }

  document.querySelectorAll(".plate").forEach((plate) => {
    plate.querySelectorAll("g[id]").forEach(prepare);
    // What is drawn over the cells lets the pointer through.
    plate.querySelectorAll("svg *").forEach((node) => {
      if (!node.closest(".cell") && node.localName !== "g") node.style.pointerEvents = "none";
    });
  });
  document.querySelector(".choose").hidden = false;
  stage.addEventListener("change", choose);
  policy.addEventListener("change", choose);
  document.addEventListener("keydown", (event) => { if (event.key === "Escape" && !panel.hidden) shut(); });
  choose();
})();
