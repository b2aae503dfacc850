function titleOf(design) {
  return DATA.fields.map(field => `${field.label} ${design.values[field.name]}${field.unit ? `\u00a0${field.unit}` : ""}`).join(", ");
}

function drawPair() {
  const chosen = chosenDesigns();
  for (const slot of ["a", "b"]) byId(`slot-${slot}`).setAttribute("aria-pressed", String(state.slot === slot));
  byId("drop-b").hidden = state.b === null;
  byId("sections").replaceChildren(element("div", { class: "sections" }, chosen.map(([slot, design]) => {
    const { cell_mm: cells, counts, height_mm: height } = design.block;
    const resolved = cells ? `${counts.join(" \u00d7 ")} cells of ${cells.map(each => each.toFixed(2)).join(" \u00d7 ")} mm, ${height.toFixed(1)} mm high` : `no grid, ${height.toFixed(1)} mm high`;
    return element("div", {}, [element("h3", { class: `is-${slot}` }, `${slot.toUpperCase()}: ${titleOf(design)}`), section(design.block, slot.toUpperCase()), element("p", { class: "soft" }, resolved)]);
  })));
  const rows = DATA.measures.map(kind => element("tr", {}, [element("th", { scope: "row" }, labelOf(kind)), ...chosen.map(([, design]) => {
    const found = measureOf(design, kind.name), note = [spread(found, kind), found.note.length > 90 ? `${found.note.slice(0, 88)}\u2026` : found.note].filter(text => text).join("; ");
    return element("td", { title: found.note }, [shown(found.value, kind.digits), element("small", {}, note)]);
  })]));
  const head = element("tr", {}, [element("th", { scope: "col" }, "measure"), ...chosen.map(([slot]) => element("th", { scope: "col", class: `is-${slot}` }, slot.toUpperCase()))]);
  byId("numbers").replaceChildren(element("div", { class: "scroll" }, element("table", {}, [element("thead", {}, head), element("tbody", {}, rows)])));
}

function drawFrames() {
  const chosen = chosenDesigns(), captions = [...new Set(chosen.flatMap(([, design]) => Object.keys(design.pictures)))];
  byId("frames").replaceChildren(element("div", { class: "film", tabindex: 0 }, captions.map(caption => element("figure", {}, [element("figcaption", {}, caption),
    ...chosen.filter(([, design]) => design.pictures[caption]).map(([slot, design]) => element("img", { src: design.pictures[caption], alt: `${slot.toUpperCase()}, ${caption}`, style: `border-color:var(--${slot})` }))]))));
}

function drawTrade() {
  const x = kindOf(byId("trade-x").value), y = kindOf(byId("trade-y").value);
  const known = DATA.designs.filter(design => measureOf(design, x.name).value !== null && measureOf(design, y.name).value !== null);
  if (!known.length) return byId("trade").replaceChildren(element("p", {}, "No design has both."));
  const reach = kind => range(known.flatMap(design => { const { value, low, high } = measureOf(design, kind.name); return [value, low, high]; }));
  const plot = axes({ x: { ...reach(x), label: labelOf(x) }, y: { ...reach(y), label: labelOf(y) }, width: Math.max(320, Math.min(640, byId("trade").clientWidth)), height: 380, label: `${y.title} against ${x.title}` }), points = [];
  for (const design of known) {
    const across = measureOf(design, x.name), up = measureOf(design, y.name), [cx, cy] = plot.at(across.value, up.value);
    const ends = (found, value) => [found.low ?? value, found.high ?? value];
    const [x1, x2] = ends(across, across.value).map(end => plot.at(end, up.value)[0]), [y1, y2] = ends(up, up.value).map(end => plot.at(across.value, end)[1]);
    plot.svg.append(element("path", { d: `M${x1} ${cy}H${x2}M${cx} ${y1}V${y2}`, style: "stroke:var(--mid);pointer-events:none" }));
    points.push(point(design, cx, cy, "var(--mid)", titleOf(design)));
  }
  plot.svg.append(...points);
  byId("trade").replaceChildren(plot.svg);
}

function drawTable() {
  const columns = [...DATA.fields.map(field => ({ ...field, of: design => design.values[field.name], digits: null })), ...DATA.measures.map(kind => ({ ...kind, of: design => measureOf(design, kind.name).value }))];
  const sorted = [...DATA.designs], by = columns.find(each => each.name === state.sort);
  if (by) sorted.sort((one, other) => inOrder(by.of(one) ?? Infinity, by.of(other) ?? Infinity) * (state.falling ? -1 : 1));
  const heads = columns.map(each => element("th", { scope: "col", "aria-sort": each.name === state.sort ? (state.falling ? "descending" : "ascending") : null }, element("button", {
    onclick: () => { state.falling = state.sort === each.name && !state.falling; state.sort = each.name; keepingFocus(drawTable); } }, `${labelOf(each)}${each.name === state.sort ? (state.falling ? " \u2193" : " \u2191") : ""}`)));
  const rows = sorted.map(design => element("tr", { class: ["a", "b"].filter(slot => state[slot] === design.index).join(" "), onclick: () => choose(design) }, [
    element("th", { scope: "row" }, `${design.index}${design.front ? " \u25cf" : ""}`), ...columns.map(each => element("td", {}, each.digits === null ? String(each.of(design)) : shown(each.of(design), each.digits)))]));
  byId("table").replaceChildren(element("table", {}, [element("thead", {}, element("tr", {}, [element("th", { scope: "col" }, "design"), ...heads])), element("tbody", {}, rows)]));
}

function drawHeld() {
  const others = DATA.fields.filter(field => field.name !== state.across && field.name !== state.down);
  byId("held").replaceChildren(...others.map(field => {
    const select = element("select", { "aria-label": labelOf(field) });
    fill(select, valuesOf(field.name).map(value => [String(value), String(value)]), String(state.held[field.name]), value => { state.held[field.name] = valuesOf(field.name).find(each => String(each) === value); draw(); });
    return element("label", {}, [`${labelOf(field)} `, select]);
  }));
}

// Drawing anew replaces what the keyboard stands on: the focus goes back to its place in the same section.
function keepingFocus(redraw) {
  const stops = "button, select, a, [tabindex]", held = document.activeElement, home = held && held.parentElement && held.parentElement.closest("[id]");
  const place = home ? [...home.querySelectorAll(stops)].indexOf(held) : -1;
  redraw();
  if (place >= 0 && document.activeElement === document.body) { const next = home.querySelectorAll(stops)[place]; if (next) next.focus(); }
}
function draw() { keepingFocus(drawAll); }
function drawAll() { drawHeld(); drawMap(); drawPair(); drawFrames(); byId("curves").replaceChildren(...curveCards(chosenDesigns())); drawTrade(); drawTable(); }

function begin() {
  const fields = DATA.fields.map(field => [field.name, field.label]), kinds = DATA.measures.map(kind => [kind.name, kind.title]);
  const varying = DATA.fields.filter(field => valuesOf(field.name).length > 1);
  state.across = (varying[0] || DATA.fields[0]).name;
  state.down = varying.length > 1 ? varying[1].name : null;
  for (const field of DATA.fields) { /* the value that most designs have */
    const count = value => DATA.designs.filter(design => design.values[field.name] === value).length;
    state.held[field.name] = valuesOf(field.name).reduce((best, value) => count(value) > count(best) ? value : best);
  }
  fill(byId("measure"), kinds, state.measure, value => { state.measure = value; draw(); });
  fill(byId("across"), fields, state.across, value => { if (value === state.down) state.down = state.across; state.across = value; syncAxes(); draw(); });
  fill(byId("down"), fields.length > 1 ? fields : [["", "\u2013"]], state.down, value => { if (value === state.across) state.across = state.down; state.down = value || null; syncAxes(); draw(); });
  const wanted = DATA.objectives.map(each => each.measure).filter(kindOf), spare = kinds.map(each => each[0]).filter(name => !wanted.includes(name));
  const [first, second] = [...wanted, ...spare, ...spare];
  fill(byId("trade-x"), kinds, first, drawTrade);
  fill(byId("trade-y"), kinds, second || first, drawTrade);
  if (DATA.objectives.length) byId("objectives").textContent = `(${DATA.objectives.map(each => `${kindOf(each.measure).title.toLowerCase()}, ${each.better} is better`).join("; ")})`;
  for (const slot of ["a", "b"]) byId(`slot-${slot}`).onclick = () => { state.slot = slot; drawPair(); };
  byId("drop-b").onclick = () => { state.b = null; state.slot = "a"; draw(); };
  byId("download").onclick = () => {
    const link = element("a", { href: URL.createObjectURL(new Blob([DATA.csv], { type: "text/csv" })), download: "sweep.csv" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  const ranked = DATA.designs.find(design => design.front) || DATA.designs[0];
  state.a = ranked.index;
  draw();
}

function syncAxes() { byId("across").value = state.across; byId("down").value = state.down || ""; }

begin();
