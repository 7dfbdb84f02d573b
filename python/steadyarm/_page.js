"use strict";
// What all pages share: packed curves, axes, lines, and time that runs.

// Curves: two characters a sample, from the least value of the curve to the largest.
function unpacker(alphabet) {
  const digit = new Map([...alphabet].map((letter, at) => [letter, at]));
  return ([low, high, text]) => {
    const values = [];
    for (let k = 0; k < text.length; k += 2) {
      const step = 64 * digit.get(text[k]) + digit.get(text[k + 1]);
      values.push(step === 4095 ? NaN : low + ((high - low) * step) / 4094);
    }
    return values;
  };
}
function embedded() {
  const held = document.getElementById("data");
  return held && JSON.parse(held.textContent);
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

// Lines { t, values, colour, dashed, title } on axes of a scale.
function drawLines(svg, lines, scale) {
  const { left, top, width, height } = scale.frame;
  const frame = draw(svg, "svg", { x: left, y: top, width, height, overflow: "hidden",
    style: "max-width:none", viewBox: `${left} ${top} ${width} ${height}` });
  for (const { t, values, colour, dashed, title } of lines) {
    const kind = dashed ? "curve dashed" : "curve";
    const line = draw(frame, "path", { class: kind, d: way(t, values, scale) });
    line.style.stroke = colour;
    draw(line, "title", {}, title);
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
// The values to be seen: the start may have a peak that leaves no room for the rest. If that makes
// half of the room free, peaks are cut off, and [least, most] tells how large they are.
function cutSpan(values) {
  const ordered = values.slice().sort((a, b) => a - b);
  const [least, most] = [ordered[0], ordered[ordered.length - 1]];
  const part = (share) => ordered[Math.round(share * (ordered.length - 1))];
  const spare = 0.6 * (part(0.98) - part(0.02)) || Infinity;
  const [low, up] = [Math.max(least, part(0.02) - spare), Math.min(most, part(0.98) + spare)];
  const cut = most - least > 2 * (up - low);
  return cut ? { span: widened(low, up), cut: [least, most] } : { span: widened(least, most) };
}
function widened(least, most) {
  const room = 0.05 * (most - least) || 0.05 * Math.abs(most) || 0.5;
  return [least - room, most + room];
}
function drawAxes(svg, wide, high, [from, end], [least, most], log) {
  const frame = { left: 64, top: 26, width: wide - 76, height: high - 70 };
  const [right, foot] = [frame.left + frame.width, frame.top + frame.height];
  const x = (t) => frame.left + ((t - from) / (end - from || 1)) * frame.width;
  const place = (v) => foot - ((v - least) / (most - least)) * frame.height;
  svg.setAttribute("viewBox", `0 0 ${wide} ${high}`);
  for (const t of ticks(from, end, wide / 90)) {
    draw(svg, "line", { class: "grid", x1: x(t), x2: x(t), y1: frame.top, y2: foot });
    draw(svg, "text", { class: "tick", x: x(t), y: foot + 17, "text-anchor": "middle" }, short(t));
  }
  for (const v of log ? decades(least, most) : ticks(least, most, Math.min(6, high / 45))) {
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

// A slider of time [s] that runs while it plays, so many seconds a second; returns what turns that.
function player(button, slider, speed, show) {
  let before = 0, playing = false;
  const end = Number(slider.max);
  const turn = (on) => {
    playing = on;
    button.textContent = on ? "pause" : "play";
  };
  const step = (time) => {
    if (!playing) return;
    const t = Number(slider.value) + (speed() * Math.max(0, time - before)) / 1000;
    before = time;
    if (t >= end) turn(false);
    slider.value = t;
    show();
    window.requestAnimationFrame(step);
  };
  const toggle = () => {
    turn(!playing);
    if (!playing) return;
    if (Number(slider.value) >= end) slider.value = slider.min;
    before = performance.now();
    window.requestAnimationFrame(step);
  };
  button.addEventListener("click", toggle);
  return toggle;
}
