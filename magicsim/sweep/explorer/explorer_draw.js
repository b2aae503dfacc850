"use strict";
/* Drawing: colours, numbers, axes. */
const VIRIDIS = [[68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121], [110, 206, 88], [181, 222, 43], [253, 231, 37]];

function mixed(share) {
  const place = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(place), VIRIDIS.length - 2);
  return VIRIDIS[low].map((part, channel) => Math.round(part + (place - low) * (VIRIDIS[low + 1][channel] - part)));
}

function colorAt(share) { return `rgb(${mixed(share).join(",")})`; }

/* Black or white, whichever stands out more on a colour (WCAG relative luminance). */
function inkOn(share) {
  const linear = mixed(share).map(part => { const c = part / 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; });
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] > 0.179 ? "#000" : "#fff";
}

function shown(value, digits) {
  if (value === null || value === undefined) return "\u2013";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "\u2212");
}

/* How a value and its interval read: half the width behind a plus-minus sign, or the open side. */
function spread(found, { digits, is_exact }) {
  if (!found || found.value === null) return "";
  const { value, low, high } = found;
  if (low === null && high === null) return "";
  if (low === null) return `\u2264 ${shown(high, digits)}`;
  if (high === null) return `\u2265 ${shown(low, digits)}`;
  if (low === high) return is_exact ? "exact" : "all alike";
  const halves = [value - low, high - value], mean = (halves[0] + halves[1]) / 2;
  if (Math.abs(halves[0] - halves[1]) <= 0.5 * mean) return `\u00b1 ${shown(mean, mean < 0.5 * 10 ** -digits ? digits + 1 : digits)}`;
  return `${shown(low, digits)} \u2013 ${shown(high, digits)}`;
}

function element(name, attributes = {}, children = []) {
  const isDrawing = ["svg", "g", "path", "line", "circle", "rect", "text", "polyline", "polygon", "title"].includes(name);
  const made = isDrawing ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "onclick") made.addEventListener("click", value);
    else if (value !== null && value !== undefined && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  for (const child of [].concat(children)) made.append(child);
  return made;
}

function ticks(low, high, count = 5) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find(each => each * power >= rough) * power, result = [];
  for (let tick = Math.ceil(low / step - 1e-9) * step; tick <= high + 1e-9 * step; tick += step) result.push(Number(tick.toPrecision(6)));
  return result;
}

/* Axes of a plot; `at` takes data to the drawing. A logarithmic axis has its own ticks. */
function axes({ x, y, width = 370, height = 250, label }) {
  const left = 48, right = 12, top = 12, bottom = 40;
  const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label });
  const scaleOf = axis => axis.log ? Math.log : value => value;
  const place = (axis, value, from, to) => {
    const scale = scaleOf(axis);
    return from + (scale(value) - scale(axis.low)) / (scale(axis.high) - scale(axis.low)) * (to - from);
  };
  const at = (a, b) => [place(x, a, left, width - right), place(y, b, height - bottom, top)];
  for (const tick of x.ticks || ticks(x.low, x.high)) {
    const [px] = at(tick, y.low);
    svg.append(element("line", { class: "grid-line", x1: px, x2: px, y1: top, y2: height - bottom }));
    svg.append(element("text", { x: px, y: height - bottom + 15, "text-anchor": "middle" }, String(tick)));
  }
  for (const tick of y.ticks || ticks(y.low, y.high)) {
    const [, py] = at(x.low, tick);
    svg.append(element("line", { class: "grid-line", x1: left, x2: width - right, y1: py, y2: py }));
    svg.append(element("text", { x: left - 6, y: py + 4, "text-anchor": "end" }, String(tick).replace("-", "\u2212")));
  }
  svg.append(element("path", { class: "axis-line", d: `M${left} ${top}V${height - bottom}H${width - right}` }));
  svg.append(element("text", { class: "strong", x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, x.label));
  svg.append(element("text", { class: "strong", x: -(top + height - bottom) / 2, y: 12, "text-anchor": "middle", transform: "rotate(-90)" }, y.label));
  return { svg, at, right: width - right, top };
}

function range(values, { zero = false, pad = 0.06 } = {}) {
  const real = values.filter(value => value !== null && Number.isFinite(value));
  let low = Math.min(...real), high = Math.max(...real);
  if (zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
  const room = (high - low || Math.abs(high) || 1) * pad;
  return { low: zero && low === 0 ? 0 : low - room, high: high + room };
}

/* A cut through the middle of the block, along x and z, as it would be printed; contact face down. */
function section(block, slot) {
  const [width] = block.footprint_mm, height = block.height_mm, margin = 0.9;
  const svg = element("svg", { viewBox: `${-width / 2 - margin} ${-margin} ${width + 2 * margin} ${height + 2 * margin + 1.2}`, role: "img", "aria-label": `Section of design ${slot}` });
  svg.append(element("rect", { x: -width / 2, y: 0, width, height, style: "fill:var(--body);stroke:var(--edge);stroke-width:.08" }));
  if (block.counts) {
    const pitch = [0, 2].map(axis => block.cell_mm[axis] + block.wall_mm), [cx, , cz] = block.cell_mm;
    for (let i = 0; i < block.counts[0]; i++) for (let k = 0; k < block.counts[2]; k++) {
      const x = -width / 2 + block.skin_mm + block.wall_mm / 2 + i * pitch[0], y = block.skin_mm + block.wall_mm / 2 + k * pitch[1];
      svg.append(element("rect", { x, y, width: cx, height: cz, style: "fill:var(--infill)" }));
    }
  }
  const y = height + 1.1;
  svg.append(element("path", { d: `M${-width / 2} ${y - .4}V${y + .4}M${-width / 2} ${y}H${-width / 2 + 5}M${-width / 2 + 5} ${y - .4}V${y + .4}`, style: "stroke:var(--soft);stroke-width:.1;fill:none" }));
  svg.append(element("text", { x: -width / 2 + 5.5, y: y + .35, style: "font-size:1px" }, "5 mm"));
  svg.append(element("text", { x: width / 2, y: y + .35, "text-anchor": "end", style: "font-size:1px" }, "contact face"));
  return svg;
}
