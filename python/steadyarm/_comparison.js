"use strict";
// Heads of the tables become buttons: the first press sorts upwards, the next one downwards.
function value(cell) {
  if (!cell.dataset.value) return cell.tagName === "TH" ? cell.textContent : null;
  return Number(cell.dataset.value.replace("inf", "Infinity"));
}
function sorted(rows, column, sign) {
  return rows.map((row, at) => ({ row, at, value: value(row.cells[column]) })).sort((a, b) => {
    if (a.value === null || b.value === null) {
      return (a.value === null) - (b.value === null) || a.at - b.at;
    }
    if (typeof a.value === "string") return sign * a.value.localeCompare(b.value) || a.at - b.at;
    return sign * (a.value < b.value ? -1 : a.value > b.value ? 1 : 0) || a.at - b.at;
  });
}
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const order = head.getAttribute("aria-sort") === "ascending" ? "descending" : "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", order);
      const rows = sorted([...table.tBodies[0].rows], column, order === "ascending" ? 1 : -1);
      table.tBodies[0].append(...rows.map((each) => each.row));
    });
  });
}

// Curves: two characters a sample, from the least value of the curve to the largest.
const held = document.getElementById("data");
if (held) start(JSON.parse(held.textContent));

function start(data) {
  const digit = new Map([...data.alphabet].map((letter, at) => [letter, at]));
  const unpacked = ([low, high, text]) => {
    const values = [];
    for (let k = 0; k < text.length; k += 2) {
      const step = 64 * digit.get(text[k]) + digit.get(text[k + 1]);
      values.push(step === 4095 ? NaN : low + ((high - low) * step) / 4094);
    }
    return values;
  };
  for (const scene of data.scenes) {
    for (const curve of scene.curves) {
      curve.t = unpacked(curve.t);
      for (const name of ["e", "tau"]) curve[name] = curve[name].map(unpacked);
      curve.e = curve.e.map((joint) => joint.map((exponent) => 10 ** exponent));
      if (curve.arm) {
        curve.arm = { t: unpacked(curve.arm.t), places: curve.arm.places.map(unpacked) };
      }
    }
  }
  const scenes = data.scenes.filter((scene) => scene.curves.length);
  startCurves(scenes);
  startArms(scenes);
}

function option(select, text, index) {
  const made = document.createElement("option");
  made.textContent = text;
  made.value = index;
  select.append(made);
}
function draw(svg, tag, attributes, text) {
  const made = document.createElementNS(svg.namespaceURI, tag);
  for (const [name, one] of Object.entries(attributes)) made.setAttribute(name, one);
  if (text !== undefined) made.textContent = text;
  svg.append(made);
  return made;
}
function short(number) {
  if (number === 0) return "0";
  const size = Math.abs(number);
  return size >= 1e5 || size < 1e-3 ? number.toExponential(0) : String(Number(number.toPrecision(3)));
}

function startCurves(scenes) {
  const section = document.getElementById("curves");
  const [chosen, signal, joint] = ["scene", "signal", "joint"].map((name) =>
    section.querySelector(`[name=${name}]`));
  const boxes = section.querySelector("fieldset");
  scenes.forEach((scene, at) => option(chosen, scene.name || "all", at));
  section.querySelector(".scene").hidden = scenes.length < 2;
  const fill = () => {
    const scene = scenes[chosen.value];
    const last = joint.value;
    joint.replaceChildren();
    const joints = Math.max(...scene.curves.map((curve) => curve.e.length));
    for (let n = 0; n < joints; n++) option(joint, String(n + 1), n);
    joint.value = last && last < joints ? last : 0;
    boxes.querySelectorAll("label").forEach((label) => label.remove());
    scene.curves.forEach((curve, at) => {
      const label = document.createElement("label");
      const box = document.createElement("input");
      const line = document.createElement("i");
      box.type = "checkbox";
      box.checked = at < 4;
      line.style.borderTopColor = `var(--c${at % 8})`;
      label.className = at % 16 < 8 ? "" : "dashed";
      const ended = curve.status === "finished" ? "" : ` (${curve.status})`;
      label.append(box, line, curve.name + ended);
      boxes.append(label);
    });
    show();
  };
  const show = () => {
    const picked = [...boxes.querySelectorAll("input")].map((box) => box.checked);
    drawCurves(section, scenes[chosen.value].curves, picked, signal.value, Number(joint.value));
  };
  chosen.addEventListener("change", fill);
  for (const control of [signal, joint, boxes]) control.addEventListener("change", show);
  section.hidden = false;
  fill();
  let wide = section.clientWidth;
  window.addEventListener("resize", () => {
    if (section.clientWidth !== wide) show();
    wide = section.clientWidth;
  });
}

function drawCurves(section, curves, picked, signal, joint) {
  const svg = section.querySelector(".chart");
  const wide = Math.max(280, Math.min(860, section.clientWidth));
  const high = Math.round(Math.min(400, Math.max(260, 0.55 * wide)));
  const edge = { left: 64, right: 12, top: 26, bottom: 44 };
  const log = signal === "e";
  svg.replaceChildren();
  svg.setAttribute("viewBox", `0 0 ${wide} ${high}`);
  const shown = curves.map((curve, at) => ({ curve, at })).filter(({ curve, at }) =>
    picked[at] && curve[signal][joint]);
  const hint = section.querySelector(".hint");
  hint.textContent = shown.length ? "" : "Nothing to draw: choose a controller with this signal.";
  if (!shown.length) return;
  const sane = shown.filter(({ curve }) => ["finished", "unresolved"].includes(curve.status));
  const values = (sane.length ? sane : shown).flatMap(({ curve }) => curve[signal][joint])
    .filter((one) => Number.isFinite(one));
  const end = shown.reduce((most, { curve }) => Math.max(most, curve.t[curve.t.length - 1]), 0);
  const from = Math.min(...shown.map(({ curve }) => curve.t[0]));
  let least = Math.min(...values), most = Math.max(...values);
  if (log) {
    least = Math.log10(Math.max(least, 1e-4 * most, 1e-12));
    most = Math.log10(Math.max(most, 2e-12));
  }
  if (!log) {
    // The start may have a peak that leaves no room for the rest.
    const ordered = values.slice().sort((a, b) => a - b);
    const part = (share) => ordered[Math.round(share * (ordered.length - 1))];
    const spare = 0.6 * (part(0.98) - part(0.02)) || 1;
    const [low, up] = [Math.max(least, part(0.02) - spare), Math.min(most, part(0.98) + spare)];
    if (low > least || up < most) {
      hint.textContent = `Torques from ${short(least)} to ${short(most)} N·m; peaks are cut off.`;
    }
    [least, most] = [low, up];
  }
  const room = 0.05 * (most - least) || 0.5;
  least -= room;
  most += room;
  const x = (t) => edge.left + ((t - from) / (end - from || 1)) * (wide - edge.left - edge.right);
  const y = (v) => high - edge.bottom - ((v - least) / (most - least)) *
    (high - edge.top - edge.bottom);
  const tick = (px, py, text, upright) => {
    draw(svg, "line", upright
      ? { class: "grid", x1: px, x2: px, y1: edge.top, y2: high - edge.bottom }
      : { class: "grid", x1: edge.left, x2: wide - edge.right, y1: py, y2: py });
    draw(svg, "text", upright
      ? { class: "tick", x: px, y: py + 17, "text-anchor": "middle" }
      : { class: "tick", x: px - 7, y: py + 4, "text-anchor": "end" }, text);
  };
  for (const t of ticks(from, end, wide / 90)) tick(x(t), high - edge.bottom, short(t), true);
  for (const v of log ? decades(least, most) : ticks(least, most, 6)) {
    tick(edge.left, y(v), short(log ? 10 ** v : v), false);
  }
  const name = log ? "error, size [rad]" : "torque [N·m]";
  draw(svg, "text", { class: "name", x: 6, y: 15 }, `${name}, joint ${joint + 1}`);
  draw(svg, "text", { class: "name", x: wide - edge.right, y: high - 7, "text-anchor": "end" },
    "time [s]");
  const clip = draw(svg, "svg", { x: edge.left, y: edge.top, width: wide - edge.left - edge.right,
    height: high - edge.top - edge.bottom, overflow: "hidden", style: "max-width:none",
    viewBox: `${edge.left} ${edge.top} ${wide - edge.left - edge.right} ${
      high - edge.top - edge.bottom}` });
  for (const { curve, at } of shown) {
    let path = "", pen = "M";
    curve[signal][joint].forEach((v, k) => {
      const place = y(log ? Math.log10(v) : v);
      if (!Number.isFinite(place)) { pen = "M"; return; }
      path += `${pen}${x(curve.t[k]).toFixed(1)} ${Math.max(-9999, Math.min(9999, place)).toFixed(1)}`;
      pen = "L";
    });
    const line = draw(clip, "path", { class: at % 16 < 8 ? "curve" : "curve dashed", d: path });
    line.style.stroke = `var(--c${at % 8})`;
    draw(line, "title", {}, `${curve.name}, seed ${curve.seed}`);
  }
}
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(2, count) || 1;
  const unit = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * unit).find((one) => one >= raw);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}
function decades(low, high) {
  const factors = high - low > 2 ? [1] : high - low > 0.8 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 7];
  const found = [];
  for (let decade = Math.floor(low); decade <= high; decade++) {
    for (const factor of factors) {
      const place = decade + Math.log10(factor);
      if (place >= low && place <= high) found.push(place);
    }
  }
  return found.filter((_, at) => at % Math.ceil(found.length / 9) === 0);
}

// Two arms side by side, at the same time and in the same scale.
function startArms(scenes) {
  const curves = scenes.flatMap((scene) => scene.curves.filter((curve) => curve.arm).map(
    (curve) => ({ name: scenes.length > 1 ? `${scene.name}: ${curve.name}` : curve.name,
      ended: curve.status === "finished", t: curve.arm.t, places: curve.arm.places })));
  const section = document.getElementById("arms");
  if (!curves.length) return;
  const [left, right, slider, now, play] = ["left", "right", "time", "now", "play"].map((name) =>
    section.querySelector(`[name=${name}]`));
  const pictures = section.querySelectorAll("svg");
  for (const select of [left, right]) curves.forEach((curve, at) => option(select, curve.name, at));
  left.value = 0;
  const ended = scenes[0].curves.filter((curve) => curve.arm && curve.status === "finished");
  right.value = Math.max(ended.length - 1, Math.min(1, curves.length - 1));
  const sane = curves.filter((curve) => curve.ended);
  const all = (side) => (sane.length ? sane : curves).flatMap((curve) => curve.places.filter((_, k) => k % 2 === side).flat());
  const span = [0, 1].map((side) => all(side).reduce(([a, b], one) => [Math.min(a, one),
    Math.max(b, one)], [Infinity, -Infinity]));
  const size = 1.16 * Math.max(span[0][1] - span[0][0], span[1][1] - span[1][0], 1e-6);
  const middle = span.map(([a, b]) => (a + b) / 2);
  const end = Math.max(...curves.map((curve) => curve.t[curve.t.length - 1]));
  const place = (curve, joint, k) => [0, 1].map((side) => {
    const at = (curve.places[2 * joint + side][k] - middle[side]) / size;
    return (150 + (side ? -300 : 300) * at).toFixed(1);
  });
  const show = () => {
    const t = (slider.value / 1000) * end;
    now.textContent = `${t.toFixed(2)} s`;
    [left, right].forEach((select, number) => {
      const curve = curves[select.value], svg = pictures[number];
      let k = curve.t.findIndex((one) => one >= t);
      if (k < 0) k = curve.t.length - 1;
      const joints = curve.places.length / 2;
      const chain = [...Array(joints).keys()].map((joint) => place(curve, joint, k));
      const way = [...Array(k + 1).keys()].map((past) => place(curve, joints - 1, past));
      svg.setAttribute("viewBox", "0 0 300 300");
      svg.replaceChildren();
      draw(svg, "polyline", { class: "trace", points: way.join(" ") });
      draw(svg, "polyline", { class: "link", points: chain.join(" ") });
      for (const [cx, cy] of chain) draw(svg, "circle", { class: "knee", cx, cy, r: 4 });
    });
  };
  let before = 0, playing = false;
  const step = (time) => {
    if (!playing) return;
    const next = Number(slider.value) + (time - before) / end;
    before = time;
    slider.value = next;
    if (next >= 1000) stop();
    show();
    window.requestAnimationFrame(step);
  };
  const stop = () => { playing = false; play.textContent = "play"; };
  play.addEventListener("click", () => {
    if (playing) { stop(); return; }
    playing = true;
    play.textContent = "pause";
    if (Number(slider.value) >= 1000) slider.value = 0;
    before = performance.now();
    window.requestAnimationFrame(step);
  });
  slider.step = "any";
  slider.addEventListener("input", show);
  for (const select of [left, right]) select.addEventListener("change", show);
  section.hidden = false;
  show();
}
