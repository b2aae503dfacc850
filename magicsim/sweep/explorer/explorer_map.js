/* The page: what is chosen, and everything that follows from it. */
const DATA = JSON.parse(document.getElementById("data").textContent);
const byId = id => document.getElementById(id);
const kindOf = name => DATA.measures.find(each => each.name === name);
const labelOf = axis => axis.unit ? `${axis.label || axis.title} [${axis.unit}]` : axis.label || axis.title;
const state = { measure: (DATA.objectives[0] || DATA.measures[0]).measure || DATA.measures[0].name, across: null, down: null, held: {}, slot: "a", a: null, b: null, sort: null, falling: false };

function valuesOf(field) {
  return [...new Set(DATA.designs.map(design => design.values[field]))].sort(inOrder);
}

function inOrder(one, other) { return one < other ? -1 : one > other ? 1 : 0; }

/* Where a value stands on an axis: itself, or the place of a name among the names. */
function placeOf(field, value) { return typeof value === "string" ? valuesOf(field).indexOf(value) : value; }

function fill(select, options, chosen, changed) {
  select.replaceChildren(...options.map(([value, text]) => element("option", { value, selected: value === chosen }, text)));
  select.onchange = () => changed(select.value);
}

function measureOf(design, name) { return design.measures[name] || { value: null, low: null, high: null, note: "" }; }

function choose(design) {
  state[state.slot] = design.index;
  if (state.slot === "b" && state.a === design.index) state.b = null;
  draw();
}

function chosenDesigns() {
  return ["a", "b"].filter(slot => state[slot] !== null).map(slot => [slot, DATA.designs.find(design => design.index === state[slot])]);
}

/* Colours span the intervals, so that what noise makes looks alike; where no two designs are told apart there is one colour. */
function scaleOf(name) {
  const values = DATA.designs.map(design => measureOf(design, name)).filter(found => found.value !== null).flatMap(({ value, low, high }) => [value, low ?? value, high ?? value]);
  const low = Math.min(...values), high = Math.max(...values), isFlat = !(high > low) || ["indistinguishable", "saturated"].includes(kindOf(name).verdict);
  return { low, high, at: value => isFlat ? 0.5 : (value - low) / (high - low), empty: !values.length };
}

function cell(design, scale, kind, extra = "") {
  const found = measureOf(design, kind.name), share = found.value === null ? null : scale.at(found.value);
  const marks = ["a", "b"].filter(slot => state[slot] === design.index);
  const where = Object.entries(design.values).map(([field, value]) => `${DATA.fields.find(each => each.name === field).label} ${value}`).join(", ");
  const text = found.value === null ? "no value" : `${shown(found.value, kind.digits)} ${kind.unit} ${spread(found, kind)}`;
  return element("button", {
    class: ["cell", ...marks, ...(share === null ? ["none"] : [])].join(" "), "data-design": design.index,
    style: share === null ? null : `background:${colorAt(share)};color:${inkOn(share)}`,
    title: `${where}: ${text}${found.note ? ` (${found.note})` : ""}`, "aria-label": `${where}: ${kind.title} ${text}`, onclick: () => choose(design),
  }, [`${extra}${shown(found.value, kind.digits)}`, element("small", {}, spread(found, kind)), ...(design.front ? [element("span", { class: "star" }, "\u25cf")] : [])]);
}

function drawMap() {
  const kind = kindOf(state.measure), scale = scaleOf(state.measure), map = byId("map");
  const xs = valuesOf(state.across), ys = state.down ? valuesOf(state.down) : [null];
  const isGrid = xs.length * ys.length <= 3 * DATA.designs.length;
  const inMap = design => isGrid && DATA.fields.every(field => [state.across, state.down].includes(field.name) || design.values[field.name] === state.held[field.name]);
  const down = DATA.fields.find(field => field.name === state.down), across = DATA.fields.find(field => field.name === state.across);
  const parts = [];
  if (isGrid) {
    const grid = element("div", { class: "grid", style: `grid-template-columns:minmax(30px,max-content) repeat(${xs.length},minmax(0,1fr))` });
    for (const y of [...ys].reverse()) {
      grid.append(element("div", { class: "tick down" }, y === null ? "" : String(y)));
      for (const x of xs) {
        const design = DATA.designs.find(each => inMap(each) && each.values[state.across] === x && (y === null || each.values[state.down] === y));
        grid.append(design ? cell(design, scale, kind) : element("div", { class: "cell none" }));
      }
    }
    grid.append(element("div"), ...xs.map(x => element("div", { class: "tick" }, String(x))));
    parts.push(...(down ? [element("div", { class: "axis down" }, `\u2191 ${labelOf(down)}`)] : []), grid, element("div", { class: "axis" }, `${labelOf(across)} \u2192`));
  } else parts.push(scatter(state.across, state.down, kind, scale));
  const others = DATA.designs.filter(design => isGrid && !inMap(design));
  if (others.length) {
    const named = design => DATA.fields.filter(field => field.name !== state.across && field.name !== state.down && design.values[field.name] !== state.held[field.name]).map(field => `${field.label} ${design.values[field.name]}${field.unit ? ` ${field.unit}` : ""}: `).join("");
    parts.push(element("div", { class: "others" }, [element("span", { class: "soft" }, "Not in the map:"), ...others.map(design => cell(design, scale, kind, named(design)))]));
  }
  map.replaceChildren(...parts);
  const ramp = VIRIDIS.map((_, place) => colorAt(place / (VIRIDIS.length - 1))).join(",");
  byId("scale").replaceChildren(...(scale.empty ? [] : [element("div", { class: "ramp", style: `background:linear-gradient(90deg,${ramp})` }),
    element("div", { class: "ends" }, [shown(scale.low, kind.digits), labelOf(kind), shown(scale.high, kind.digits)].map(text => element("span", {}, text)))]));
  byId("meaning").textContent = `${kind.verdict && kind.verdict !== "told apart" ? `Designs are ${kind.verdict} here. ` : ""}${kind.meaning} ${kind.better ? `${kind.better === "higher" ? "Higher" : "Lower"} is better. ` : ""}\u25cf: in the Pareto front.`;
}

/* Designs that are no grid, as points in the plane of two fields. */
function scatter(across, down, kind, scale) {
  const axisOf = name => DATA.fields.find(field => field.name === name);
  const placesOf = field => valuesOf(field).map(value => placeOf(field, value));
  const plot = axes({ x: { ...range(placesOf(across)), label: labelOf(axisOf(across)) }, y: { ...range(down ? placesOf(down) : [0, 1]), label: down ? labelOf(axisOf(down)) : "" }, width: 520, height: 380, label: "Designs" });
  for (const design of DATA.designs) {
    const found = measureOf(design, kind.name), [cx, cy] = plot.at(placeOf(across, design.values[across]), down ? placeOf(down, design.values[down]) : 0.5);
    plot.svg.append(point(design, cx, cy, found.value === null ? "var(--faint)" : colorAt(scale.at(found.value)), `${shown(found.value, kind.digits)} ${kind.unit}`));
  }
  return plot.svg;
}

function point(design, cx, cy, color, text) {
  const marks = ["a", "b"].filter(slot => state[slot] === design.index);
  const group = element("g", { class: "point", "data-design": design.index, style: "cursor:pointer", onclick: () => choose(design) }, [element("title", {}, `design ${design.index}: ${text}`)]);
  group.append(element("circle", { cx, cy, r: 16, style: "fill:transparent" }), element("circle", { cx, cy, r: 6.5, style: `fill:${color};stroke:var(--card);stroke-width:1` }));
  if (design.front) group.append(element("circle", { cx, cy, r: 9, class: "ring", style: "stroke:var(--ink);stroke-width:1.4" }));
  for (const slot of marks) group.append(element("circle", { cx, cy, r: 12, class: `ring is-${slot}` }));
  return group;
}

