/* Curves of the chosen designs. */
function column(design, curve, name) { return design.curves[curve] ? design.curves[curve][name] : null; }

function polyline(plot, slot, xs, ys, { dashed = false, dots = true } = {}) {
  const points = xs.map((x, number) => [x, ys[number]]).filter(pair => pair[1] !== null).map(pair => plot.at(...pair));
  plot.svg.append(element("polyline", { class: `line is-${slot}`, points: points.map(pair => pair.join(",")).join(" "), "stroke-dasharray": dashed ? "5 4" : null }));
  if (dots) for (const [cx, cy] of points) plot.svg.append(element("circle", { class: `dot is-${slot}`, cx, cy, r: 3 }));
}

function card(title, svg, note) {
  return element("div", { class: "card" }, [element("h3", {}, title), svg, ...(note ? [element("p", { class: "soft" }, note)] : [])]);
}

/* One card of curves; `parts` of {curve, x, y, dashed, dots}. */
function curveCard(chosen, { title, x, y, parts, note }) {
  const used = chosen.filter(([, design]) => parts.some(part => column(design, part.curve, part.y)));
  if (!used.length) return null;
  const all = name => used.flatMap(([, design]) => parts.flatMap(part => column(design, part.curve, part[name]) || []));
  const xs = all("x"), across = x.log ? { low: Math.min(...xs) * 0.9, high: Math.max(...xs) * 1.1 } : range(xs, { zero: x.zero });
  const plot = axes({ x: { ...across, ...x }, y: { ...range([...all("y"), ...(y.marks || [])], { zero: y.zero }), ...y }, label: title });
  for (const line of y.marks || []) {
    const [x1, y1] = plot.at(across.low, line);
    plot.svg.append(element("line", { x1, x2: plot.right, y1, y2: y1, style: "stroke:var(--mid);stroke-dasharray:2 3" }));
  }
  for (const [slot, design] of used) for (const part of parts) {
    const px = column(design, part.curve, part.x), py = column(design, part.curve, part.y);
    if (py) polyline(plot, slot, px, py, part);
  }
  return card(title, plot.svg, note);
}

const DISTANCES = [0.5, 1, 2, 5, 10, 20, 50];

function inside(values, chosen, curve, name) {
  const all = chosen.flatMap(([, design]) => column(design, curve, name) || []);
  return values.filter(value => value >= 0.9 * Math.min(...all) && value <= 1.1 * Math.max(...all));
}

function localisationCard(chosen) {
  const used = chosen.filter(([, design]) => design.curves.localisation);
  if (!used.length) return null;
  const [width, length] = used[0][1].block.footprint_mm;
  const svg = element("svg", { viewBox: `${-length / 2 - 1} ${-width / 2 - 2.4} ${length + 2} ${width + 4.4}`, role: "img", "aria-label": "True and predicted places of touches" });
  svg.append(element("rect", { x: -length / 2, y: -width / 2, width: length, height: width, style: "fill:none;stroke:var(--edge);stroke-width:.12" }));
  for (const [slot, design] of used) {
    const places = design.curves.localisation;
    places.x_mm.forEach((x, number) => {
      const from = [places.y_mm[number], x], to = [places.predicted_y_mm[number], places.predicted_x_mm[number]];
      svg.append(element("line", { class: `is-${slot}`, x1: from[0], y1: from[1], x2: to[0], y2: to[1], style: "stroke-width:.22" }));
      svg.append(element("circle", { class: `dot is-${slot}`, cx: to[0], cy: to[1], r: .3 }));
      svg.append(element("circle", { cx: from[0], cy: from[1], r: .42, style: "fill:none;stroke:var(--ink);stroke-width:.14" }));
    });
  }
  svg.append(element("text", { class: "strong", x: 0, y: width / 2 + 1.7, "text-anchor": "middle", style: "font-size:1.1px" }, `y, ${length} mm`));
  svg.append(element("text", { class: "strong", x: -length / 2, y: -width / 2 - .7, style: "font-size:1.1px" }, `x, ${width} mm`));
  return card("Where touches are and what the regressor says", svg, "Rings: true places. Dots: predicted without that touch.");
}

function curveCards(chosen) {
  const distance = { label: "distance [mm], logarithmic", log: true };
  const cards = [
    curveCard(chosen, { title: "Force against depth", x: { label: "depth [mm]", zero: true }, y: { label: "force [N]", zero: true }, parts: [{ curve: "force", x: "depth_mm", y: "force_n" }] }),
    curveCard(chosen, { title: "Grid similarity against depth", x: { label: "depth [mm]", zero: true }, y: { label: "similarity S" }, parts: [{ curve: "similarity", x: "depth_mm", y: "similarity" }], note: "On the axis, with the same options for every design." }),
    curveCard(chosen, { title: "Entropy against distance", x: { ...distance, ticks: inside(DISTANCES, chosen, "approach", "gap_mm") }, y: { label: "entropy E [bit]", zero: true }, parts: [{ curve: "approach", x: "gap_mm", y: "entropy" }] }),
    curveCard(chosen, { title: "Correlation and detection against distance", x: { ...distance, ticks: inside(DISTANCES, chosen, "approach", "gap_mm") }, y: { label: "C, share of frames", low: -0.1, high: 1.05, marks: [0.5] }, parts: [{ curve: "approach", x: "gap_mm", y: "rate" }, { curve: "approach", x: "gap_mm", y: "correlation", dashed: true, dots: false }], note: "Solid: share of frames called Approaching at 5 % false alarms. Dashed: correlation C." }),
  ];
  cards.push(curveCard(chosen, { title: "Contact against depth", x: { label: "depth [mm]", zero: true }, y: { label: "AUC, accuracy", marks: [1] }, parts: [{ curve: "contact", x: "depth_mm", y: "auc" }, { curve: "contact", x: "depth_mm", y: "accuracy", dashed: true }], note: "Solid: contact AUC. Dashed: contact accuracy." }));
  for (const pattern of ["lines", "dots"]) cards.push(
    curveCard(chosen, { title: `Pattern of ${pattern}`, x: { label: `spacing of ${pattern} [mm]` }, y: { label: "d\u2032", zero: true, marks: [2] }, parts: [{ curve: `${pattern}_d_prime`, x: "spacing_mm", y: "d_prime" }], note: "Told apart from a plain plate at d\u2032 = 2." }));
  cards.push(localisationCard(chosen));
  return cards.filter(each => each);
}
