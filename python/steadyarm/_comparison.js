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
  if (size >= 1e5 || size < 1e-3) return number.toExponential(0);
  return String(Number(number.toPrecision(3)));
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
  const shown = curves.map((curve, at) => ({ curve, at })).filter(({ curve, at }) =>
    picked[at] && curve[signal][joint]);
  const hint = section.querySelector(".hint");
  hint.textContent = shown.length ? "" : "Nothing to draw: choose a controller with this signal.";
  svg.replaceChildren();
  if (!shown.length) return;
  const sane = shown.filter(({ curve }) => ["finished", "unresolved"].includes(curve.status));
  const values = (sane.length ? sane : shown).flatMap(({ curve }) => curve[signal][joint])
    .filter((one) => Number.isFinite(one));
  const span = signal === "e" ? errorSpan(values) : torqueSpan(values, hint);
  const from = Math.min(...shown.map(({ curve }) => curve.t[0]));
  const end = Math.max(...shown.map(({ curve }) => curve.t[curve.t.length - 1]));
  const scale = drawAxes(svg, section.clientWidth, [from, end], span, signal === "e");
  const name = signal === "e" ? "error, size [rad]" : "torque [N·m]";
  draw(svg, "text", { class: "name", x: 6, y: 15 }, `${name}, joint ${joint + 1}`);
  const { left, top, width, height } = scale.frame;
  const frame = draw(svg, "svg", { x: left, y: top, width, height, overflow: "hidden",
    style: "max-width:none", viewBox: `${left} ${top} ${width} ${height}` });
  for (const { curve, at } of shown) {
    const path = way(curve.t, curve[signal][joint], scale);
    const line = draw(frame, "path", { class: at % 16 < 8 ? "curve" : "curve dashed", d: path });
    line.style.stroke = `var(--c${at % 8})`;
    draw(line, "title", {}, `${curve.name}, seed ${curve.seed}`);
  }
}
function way(t, values, { x, y }) {
  let path = "", pen = "M";
  values.forEach((value, k) => {
    const place = Math.max(-9999, Math.min(9999, y(value)));
    if (Number.isNaN(place)) { pen = "M"; return; }
    path += `${pen}${x(t[k]).toFixed(1)} ${place.toFixed(1)}`;
    pen = "L";
  });
  return path;
}
// Exponents of ten of the errors to be seen: four decades at the most.
function errorSpan(values) {
  const most = Math.max(...values);
  const least = Math.max(Math.min(...values), 1e-4 * most, 1e-12);
  return widened(Math.log10(least), Math.log10(Math.max(most, 2e-12)));
}
// Torques to be seen: the start may have a peak that leaves no room for the rest.
function torqueSpan(values, hint) {
  const ordered = values.slice().sort((a, b) => a - b);
  const [least, most] = [ordered[0], ordered[ordered.length - 1]];
  const part = (share) => ordered[Math.round(share * (ordered.length - 1))];
  const spare = 0.6 * (part(0.98) - part(0.02)) || 1;
  const [low, up] = [Math.max(least, part(0.02) - spare), Math.min(most, part(0.98) + spare)];
  if (low > least || up < most) {
    hint.textContent = `Torques from ${short(least)} to ${short(most)} N·m; peaks are cut off.`;
  }
  return widened(low, up);
}
function widened(least, most) {
  const room = 0.05 * (most - least) || 0.5;
  return [least - room, most + room];
}
function drawAxes(svg, room, [from, end], [least, most], log) {
  const wide = Math.max(280, Math.min(860, room));
  const high = Math.round(Math.min(400, Math.max(260, 0.55 * wide)));
  const frame = { left: 64, top: 26, width: wide - 76, height: high - 70 };
  const [right, foot] = [frame.left + frame.width, frame.top + frame.height];
  const x = (t) => frame.left + ((t - from) / (end - from || 1)) * frame.width;
  const place = (v) => foot - ((v - least) / (most - least)) * frame.height;
  svg.setAttribute("viewBox", `0 0 ${wide} ${high}`);
  for (const t of ticks(from, end, wide / 90)) {
    draw(svg, "line", { class: "grid", x1: x(t), x2: x(t), y1: frame.top, y2: foot });
    draw(svg, "text", { class: "tick", x: x(t), y: foot + 17, "text-anchor": "middle" }, short(t));
  }
  for (const v of log ? decades(least, most) : ticks(least, most, 6)) {
    const y = place(v);
    draw(svg, "line", { class: "grid", x1: frame.left, x2: right, y1: y, y2: y });
    draw(svg, "text", { class: "tick", x: frame.left - 7, y: y + 4, "text-anchor": "end" },
      short(log ? 10 ** v : v));
  }
  draw(svg, "text", { class: "name", x: right, y: high - 7, "text-anchor": "end" }, "time [s]");
  return { frame, x, y: (v) => place(log ? Math.log10(v) : v) };
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
  const part = (name) => section.querySelector(`[name=${name}]`);
  const [slider, sides] = [part("time"), [part("left"), part("right")]];
  const pictures = section.querySelectorAll("svg");
  for (const select of sides) curves.forEach((curve, at) => option(select, curve.name, at));
  const ended = scenes[0].curves.filter((curve) => curve.arm && curve.status === "finished");
  sides[0].value = 0;
  sides[1].value = Math.max(ended.length - 1, Math.min(1, curves.length - 1));
  const view = viewed(curves);
  const end = Math.max(...curves.map((curve) => curve.t[curve.t.length - 1]));
  const show = () => {
    const t = (slider.value / 1000) * end;
    part("now").textContent = `${t.toFixed(2)} s`;
    sides.forEach((select, side) => drawArm(pictures[side], curves[select.value], t, view));
  };
  slider.step = "any";
  for (const control of [slider, ...sides]) control.addEventListener("input", show);
  playWith(part("play"), slider, end, show);
  section.hidden = false;
  show();
}
// Where a joint is on a square of 300, from the places of all arms that went their way.
function viewed(curves) {
  const sane = curves.filter((curve) => curve.ended);
  const spans = [0, 1].map((side) => {
    const all = (sane.length ? sane : curves).flatMap((curve) =>
      curve.places.filter((_, k) => k % 2 === side).flat());
    return all.reduce(([a, b], one) => [Math.min(a, one), Math.max(b, one)], [Infinity, -Infinity]);
  });
  const size = 1.16 * Math.max(...spans.map(([a, b]) => b - a), 1e-6);
  return (curve, joint, k) => spans.map(([a, b], side) => {
    const at = (curve.places[2 * joint + side][k] - (a + b) / 2) / size;
    return (150 + (side ? -300 : 300) * at).toFixed(1);
  });
}
function drawArm(svg, curve, t, view) {
  const after = curve.t.findIndex((one) => one >= t);
  const k = after < 0 ? curve.t.length - 1 : after;
  const joints = curve.places.length / 2;
  const chain = [...Array(joints).keys()].map((joint) => view(curve, joint, k));
  const trace = [...Array(k + 1).keys()].map((past) => view(curve, joints - 1, past));
  svg.setAttribute("viewBox", "0 0 300 300");
  svg.replaceChildren();
  draw(svg, "polyline", { class: "trace", points: trace.join(" ") });
  draw(svg, "polyline", { class: "link", points: chain.join(" ") });
  for (const [cx, cy] of chain) draw(svg, "circle", { class: "knee", cx, cy, r: 4 });
}
function playWith(button, slider, end, show) {
  let before = 0, playing = false;
  const turn = (on) => {
    playing = on;
    button.textContent = on ? "pause" : "play";
  };
  const step = (time) => {
    if (!playing) return;
    slider.value = Number(slider.value) + (time - before) / end;
    before = time;
    if (Number(slider.value) >= 1000) turn(false);
    show();
    window.requestAnimationFrame(step);
  };
  button.addEventListener("click", () => {
    turn(!playing);
    if (!playing) return;
    if (Number(slider.value) >= 1000) slider.value = 0;
    before = performance.now();
    window.requestAnimationFrame(step);
  });
}
