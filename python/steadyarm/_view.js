// A run, or several side by side: arms in motion, and what their joints did.
const data = embedded();
if (data) start(data);

function start(data) {
  const unpacked = unpacker(data.alphabet);
  const side = (packed) => (typeof packed === "number" ? packed : unpacked(packed));
  const places = (points) => points.map((point) => point.map(side));
  const runs = data.runs.map((run, at) => {
    const { t, e, tau } = run.curves;
    const curves = { t: unpacked(t), e: e.map(unpacked), tau: tau.map(unpacked) };
    const arm = run.arm && {
      t: unpacked(run.arm.t), actual: places(run.arm.actual),
      off: places(run.arm.off).map((point) => point.map(squared)),
      load: run.arm.load && places(run.arm.load)[0], masses: run.arm.masses,
    };
    return { name: run.name, sound: ["finished", "unresolved"].includes(run.status), curves, arm,
      colour: `var(--c${at % 8})`, dashed: at % 16 >= 8 };
  });
  const section = document.getElementById("view");
  section.hidden = false;
  const part = (name) => section.querySelector(`[name=${name}]`);
  const slider = part("time");
  const from = Math.min(...runs.map(({ curves }) => curves.t[0]));
  const end = Math.max(...runs.map(({ curves }) => curves.t[curves.t.length - 1]));
  Object.assign(slider, { min: from, max: end, step: (end - from) / 1000 || "any", value: from });
  for (const speed of [0.1, 0.25, 0.5, 1, 2, 4]) option(part("speed"), `×${speed}`, speed);
  part("speed").value = 1;
  const stages = startStages(section, data, runs);
  const charts = startCharts(section, data, runs, [from, end], (t) => seek(t));
  let shown = 0;
  const show = () => {
    if (!shown) shown = window.requestAnimationFrame(() => { shown = 0; paint(); });
  };
  const paint = () => {
    const t = Number(slider.value);
    part("now").textContent = `${t.toFixed(2)} s`;
    slider.setAttribute("aria-valuetext", `${t.toFixed(2)} seconds`);
    stages.show(t);
    charts.show(t);
  };
  const seek = (t) => { slider.value = t; show(); };
  const all = () => { charts.fit(); show(); };
  stages.changed = show;
  charts.changed = all;
  slider.addEventListener("input", show);
  const toggle = player(part("play"), slider, () => Number(part("speed").value), show);
  part("play").disabled = !(end > from);
  keys(toggle, (steps) => seek(Number(slider.value) + 0.04 * steps));
  window.addEventListener("resize", all);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", all);
  charts.fit();
  paint();
}
function squared(root) {
  return typeof root === "number" ? root * Math.abs(root) : root.map(squared);
}
function keys(toggle, step) {
  document.addEventListener("keydown", (event) => {
    if (event.target.closest("select, button")) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === " ") toggle();
    else if (event.key === "," || event.key === ".") step(event.key === "," ? -1 : 1);
    else return;
    event.preventDefault();
  });
}

// What a joint did: two charts with a cursor at the time of the slider.
function startCharts(section, data, runs, span, seek) {
  const joint = section.querySelector("[name=joint]");
  const names = section.querySelector(".names");
  data.joints.forEach(({ name }, at) => option(joint, name, at));
  const outputs = runs.map((run) => {
    const label = mark(names, run.name, run.dashed ? "dashed" : "");
    label.querySelector("i").style.borderTopColor = run.colour;
    return label.appendChild(document.createElement("output"));
  });
  const charts = [...section.querySelectorAll(".chart")].filter((svg) => {
    const known = runs.some(({ curves }) => curves[svg.dataset.signal].length);
    svg.parentElement.hidden = !known;
    return known;
  });
  const made = { changed: () => {} };
  const scales = new Map();
  made.fit = () => charts.forEach((svg) => scales.set(svg,
    drawChart(svg, runs, Number(joint.value), data.joints[joint.value], span)));
  made.show = (t) => {
    const [at, unit] = [Number(joint.value), `m${data.joints[joint.value].length}`];
    scales.forEach(({ cursor, scale }) => {
      cursor.setAttribute("x1", scale.x(t));
      cursor.setAttribute("x2", scale.x(t));
    });
    runs.forEach(({ curves }, k) => {
      const [e, tau] = ["e", "tau"].map((signal) => valueAt(curves.t, curves[signal][at], t));
      const force = unit === "mm" ? "N" : "N·m";
      outputs[k].textContent = e === null ? "ended" :
        `${short(1000 * e)} ${unit}${tau === null ? "" : `, ${short(tau)} ${force}`}`;
    });
  };
  charts.forEach((svg) => pointed(svg, () => scales.get(svg).scale, span, seek));
  joint.addEventListener("change", () => made.changed());
  return made;
}
function drawChart(svg, runs, joint, { name, length }, span) {
  const unit = `m${length}`;
  const signal = svg.dataset.signal;
  const shown = runs.filter(({ curves }) => curves[signal][joint]);
  const factor = signal === "e" ? 1000 : 1;
  const shownUnit = signal === "e" ? unit : unit === "mm" ? "N" : "N·m";
  const scaled = (run) => run.curves[signal][joint].map((one) => factor * one);
  const sane = shown.filter((run) => run.sound);
  const values = (sane.length ? sane : shown).flatMap(scaled).filter(Number.isFinite);
  const room = cutSpan(values.length ? values : [0]);
  svg.nextElementSibling.textContent = room.cut ?
    `From ${room.cut.map(short).join(" to ")} ${shownUnit}; peaks are cut off.` : "";
  const wide = Math.max(280, Math.min(860, svg.parentElement.clientWidth));
  svg.replaceChildren();
  const scale = drawAxes(svg, wide, Math.round(Math.max(190, 0.36 * wide)), span, room.span, false);
  const word = signal === "e" ? "error" : "torque";
  draw(svg, "text", { class: "name", x: 6, y: 15 }, `${word} [${shownUnit}], joint ${name}`);
  drawLines(svg, shown.map((run) => ({ t: run.curves.t, values: scaled(run), colour: run.colour,
    dashed: run.dashed, title: run.name })), scale);
  const { top, height } = scale.frame;
  const cursor = draw(svg, "line", { class: "cursor", y1: top, y2: top + height });
  return { scale, cursor };
}
function valueAt(t, values, time) {
  if (!values || time > t[t.length - 1] + 1e-9 + 0.01 * (t[t.length - 1] - t[0])) return null;
  const after = t.findIndex((one) => one >= time);
  return values[after < 0 ? t.length - 1 : after];
}
// A press or a drag on a chart goes to that time.
function pointed(svg, scale, [from, end], seek) {
  const go = (event) => {
    if (!event.buttons) return;
    const box = svg.getBoundingClientRect();
    const { left, width } = scale().frame;
    const x = ((event.clientX - box.left) / box.width) * svg.viewBox.baseVal.width;
    seek(Math.max(from, Math.min(end, from + ((x - left) / width) * (end - from))));
  };
  svg.addEventListener("pointerdown", go);
  svg.addEventListener("pointermove", go);
}
function mark(parent, words, kind) {
  const label = document.createElement("span");
  const line = document.createElement("i");
  label.className = "mark";
  line.className = kind;
  label.append(line, `${words} `);
  parent.append(label);
  return label;
}

// The arms, one a stage, seen from the same side in the same scale.
function startStages(section, data, runs) {
  const moving = runs.filter((run) => run.arm && run.arm.t.length);
  const made = { changed: () => {}, show: () => {} };
  const [magnified, reset] = ["magnified", "reset"].map((name) =>
    section.querySelector(`[name=${name}]`));
  const words = section.querySelector(".keys");
  words.append("Space plays; comma and full stop step.");
  section.querySelector(".moving").hidden = reset.hidden = !moving.length;
  if (!moving.length) return made;
  if (moving.length === 1) section.classList.add("single");
  const first = firstView(data, moving);
  const view = { ...first };
  reset.hidden = data.flat;
  if (!data.flat) {
    words.prepend("Drag, or the arrow keys, turn the view; + and − zoom. ");
  }
  for (const factor of [1, 10, 100, 1000, 10000]) option(magnified, `×${factor}`, factor);
  magnified.value = firstFactor(moving, view.size);
  const holder = section.querySelector(".stages");
  const stages = moving.map((run) => stageOf(holder, run, data.flat));
  for (const { canvas } of stages) if (!data.flat) turning(canvas, view, () => made.changed());
  reset.addEventListener("click", () => { Object.assign(view, first); made.changed(); });
  magnified.addEventListener("change", () => made.changed());
  made.show = (t) => {
    const look = { ...view, factor: Number(magnified.value), room: data.room };
    for (const stage of stages) drawStage(stage, look, t);
  };
  return made;
}
function stageOf(holder, run, flat) {
  const figure = document.createElement("figure");
  const canvas = document.createElement("canvas");
  const caption = document.createElement("figcaption");
  const name = document.createElement("strong");
  const output = document.createElement("output");
  figure.className = flat ? "stage flat" : "stage";
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `The arm in motion: ${run.name}`);
  if (!flat) canvas.tabIndex = 0;
  name.textContent = run.name;
  caption.append(name);
  mark(caption, "arm", "").querySelector("i").style.borderTopColor = run.colour;
  mark(caption, "where it should be", "desired");
  if (run.arm.load) mark(caption, "payload unknown to its controller", "load");
  caption.append(output);
  figure.append(canvas, caption);
  holder.append(figure);
  return { run, canvas, output };
}
// From the side of the way of the tips, a little from above; everything fits.
function firstView(data, moving) {
  const [low, high] = data.room;
  const middle = low.map((side, k) => (side + high[k]) / 2);
  const size = Math.max(...low.map((side, k) => high[k] - side), 1e-6);
  const view = { azimuth: 0, elevation: 0.35, zoom: 1, middle, size, flat: data.flat };
  const ends = moving.flatMap(({ arm }) => [0, arm.t.length - 1].map((k) =>
    arm.actual[arm.actual.length - 1].map((side) => at(side, k))));
  const tip = [0, 1].map((k) => ends.reduce((sum, end) => sum + end[k], 0));
  view.azimuth = Math.atan2(tip[1], tip[0]) - 1.0;
  fitted(view, data.room, moving);
  return view;
}
// Moves the middle of a view so that all places are around it, and finds how much room they take.
function fitted(view, [low, high], moving) {
  const inside = (place) => place.every((side, k) =>
    side > low[k] - 0.1 * view.size && side < high[k] + 0.1 * view.size);
  const places = moving.flatMap(({ arm }) => [...arm.t.keys()].flatMap((frame) =>
    arm.actual.map((point) => point.map((side) => at(side, frame))))).filter(inside);
  const spans = [0, 1].map((k) => places.reduce(([least, most], place) => {
    const side = turned(place, view)[k];
    return [Math.min(least, side), Math.max(most, side)];
  }, [Infinity, -Infinity]));
  const [x, y] = spans.map(([least, most]) => (least + most) / 2);
  const { azimuth: a, elevation: e } = view;
  const shift = view.flat ? [x, y] : [-x * Math.sin(a) - y * Math.sin(e) * Math.cos(a),
    x * Math.cos(a) - y * Math.sin(e) * Math.sin(a), y * Math.cos(e)];
  view.middle = view.middle.map((side, k) => side + shift[k]);
  view.spans = spans.map(([least, most]) => 1.3 * Math.max(most - least, 0.1 * view.size));
}
function firstFactor(moving, size) {
  const sane = moving.filter((run) => run.sound);
  const most = Math.max(...(sane.length ? sane : moving).flatMap(({ arm }) => arm.off.flatMap(
    (point) => point.flatMap((side) => (typeof side === "number" ? [side] : side)).map(Math.abs))));
  const factor = 10 ** Math.floor(Math.log10((0.15 * size) / most));
  return Math.max(1, Math.min(10000, Number.isFinite(factor) ? factor : 1));
}
function at(side, k) {
  return typeof side === "number" ? side : side[k];
}
function turning(canvas, view, changed) {
  const turn = (x, y) => {
    view.azimuth -= x;
    view.elevation = Math.max(-0.2, Math.min(1.5, view.elevation + y));
    changed();
  };
  const zoom = (factor) => {
    view.zoom = Math.max(0.3, Math.min(8, view.zoom * factor));
    changed();
  };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) turn(event.movementX / 150, event.movementY / 150);
  });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return; // the page scrolls; two fingers on a pad come with it
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 600));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const [x, y] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[
      event.key] || [0, 0];
    if (x || y) turn(0.1 * x, 0.1 * y);
    else if (event.key === "+" || event.key === "=") zoom(1.2);
    else if (event.key === "-") zoom(1 / 1.2);
    else return;
    event.preventDefault();
  });
}
// The frame before a time and how far it is to the next one; none between places far apart.
function frameAt({ t, actual }, time, size) {
  const after = t.findIndex((one) => one > time);
  if (after < 0) return [t.length - 1, 0];
  if (after === 0) return [0, 0];
  const far = actual.some((point) => point.some((side) =>
    !(Math.abs(at(side, after) - at(side, after - 1)) < 0.2 * size)));
  const share = (time - t[after - 1]) / (t[after] - t[after - 1]);
  return far ? [share < 0.5 ? after - 1 : after, 0] : [after - 1, share];
}
function between(side, [k, share]) {
  return typeof side === "number" || !share ? at(side, k) :
    side[k] + share * (side[k + 1] - side[k]);
}
function drawStage({ run, canvas, output }, look, t) {
  const { arm } = run;
  const paper = paperOf(canvas, look);
  const frame = frameAt(arm, t, look.size);
  const chain = arm.actual.map((point) => point.map((side) => between(side, frame)));
  const off = arm.off.map((point) => point.map((side) => between(side, frame)));
  const ghost = chain.map((point, joint) => point.map((side, k) =>
    side + look.factor * off[joint][k]));
  drawGround(paper, look);
  if (!look.flat) drawShadow(paper, chain, look);
  drawTrace(paper, arm, frame[0], look, run.colour);
  const load = arm.load && arm.load.map((side) => between(side, frame));
  drawChain(paper, chain, run.colour);
  if (load && load.every(Number.isFinite)) drawLoad(paper, load, massAt(arm.masses, t));
  drawGhost(paper, ghost);
  output.textContent = told(paper, run, chain, ghost, off, look, t);
}
// What the picture says in words: how far off the tip is, and whether one can see it.
function told(paper, run, chain, ghost, off, look, t) {
  const tip = off[off.length - 1];
  const millimetres = 1000 * Math.hypot(...tip);
  const last = chain.length - 1;
  const [a, b] = [paper.seen(chain[last]), paper.seen(ghost[last])];
  const apart = Math.hypot(a[0] - b[0], a[1] - b[1]);
  const drawn = look.factor > 1 ? `, drawn ×${look.factor}` : "";
  const more = look.factor * 10 ** Math.ceil(Math.log10(6 / apart));
  const small = apart < 3 && more <= 10000 ? `, too little to be seen; draw it ×${more}` : "";
  const over = t > run.arm.t[run.arm.t.length - 1] + 0.02 ? "; the run has ended" : "";
  const far = millimetres < 1e-3 ? "less than 0.001" : short(millimetres);
  return `tip ${far} mm off${drawn}${small}${over}`;
}
function massAt(masses, t) {
  return masses.filter(([from]) => from <= t).reduce((_, [, mass]) => mass, 0);
}
// A canvas to draw on, in sharp pixels, and where a place [m] is seen on it.
function paperOf(canvas, look) {
  const { clientWidth: wide, clientHeight: high } = canvas;
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(wide * ratio) || canvas.height !== Math.round(high * ratio)) {
    canvas.width = Math.round(wide * ratio);
    canvas.height = Math.round(high * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, wide, high);
  pen.lineCap = pen.lineJoin = "round";
  pen.font = "12px system-ui, sans-serif";
  const style = window.getComputedStyle(canvas);
  const colour = (name) => style.getPropertyValue(name.replace(/^var\(|\)$/g, "")).trim();
  const scale = look.zoom * Math.min(wide / look.spans[0], high / look.spans[1]);
  const seen = (place) => {
    const [x, y, near] = turned(place, look);
    const closer = 1 / (1 - (0.22 * near) / look.size);
    return [wide / 2 + x * scale * closer, high / 2 - y * scale * closer, near, closer];
  };
  return { pen, seen, colour, wide, high, scale };
}
// Right, up and towards the eye, from the middle of what is to be seen.
function turned(place, { azimuth, elevation, middle, flat }) {
  const [x, y, z] = place.map((side, k) => side - middle[k]);
  if (flat) return [x, y, 0];
  const [sa, ca] = [Math.sin(azimuth), Math.cos(azimuth)];
  const [se, ce] = [Math.sin(elevation), Math.cos(elevation)];
  const out = x * ca + y * sa;
  return [y * ca - x * sa, z * ce - out * se, z * se + out * ce];
}
function line({ pen, seen }, places, colour, width, dash) {
  pen.beginPath();
  for (const place of places) {
    const [x, y] = seen(place);
    if (Number.isFinite(x + y)) pen.lineTo(x, y);
  }
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.setLineDash(dash || []);
  pen.stroke();
  pen.setLineDash([]);
}
function disc({ pen }, [x, y], radius, fill, stroke, width) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  if (fill) { pen.fillStyle = fill; pen.fill(); }
  if (stroke) { pen.strokeStyle = stroke; pen.lineWidth = width; pen.stroke(); }
}
function groundOf({ room: [low], size }) {
  return low[2] < -0.02 * size ? low[2] : 0;
}
// Squares of the ground, or of the plane in which the arm moves; the axes of the base.
function drawGround(paper, look) {
  const [low, high] = look.room;
  const step = ticks(0, look.size, 8)[1];
  const z = look.flat ? [] : [groundOf(look)];
  const ends = [0, 1].map((k) => {
    const spare = look.flat ? 2 * look.size : 0.2 * look.size;
    return [Math.floor((low[k] - spare) / step) * step, Math.ceil((high[k] + spare) / step) * step];
  });
  const grid = paper.colour("--line");
  for (const k of [0, 1]) {
    for (let v = ends[k][0]; v <= ends[k][1] + 1e-9; v += step) {
      const side = (other) => (k ? [other, v, ...z] : [v, other, ...z]);
      line(paper, ends[1 - k].map(side), grid, Math.abs(v) < 1e-9 ? 1.6 : 0.8);
    }
  }
  const base = [0, 0, ...z];
  ["x", "y", "z"].slice(0, look.flat ? 2 : 3).forEach((name, k) => {
    const end = base.map((side, at) => side + (at === k ? 0.75 * step : 0));
    const colour = paper.colour(["--c1", "--c2", "--c0"][k]);
    line(paper, [base, end], colour, 2);
    const [x, y] = paper.seen(end);
    write(paper, name, name === "z" ? x - 16 : x + 4, y - 3, colour);
  });
  write(paper, `squares of ${short(step)} m`, 8, paper.high - 8, paper.colour("--soft"));
}
function write({ pen }, words, x, y, colour) {
  pen.fillStyle = colour;
  pen.fillText(words, x, y);
}
// What lies under the arm shows where it is in depth.
function drawShadow(paper, chain, look) {
  const ground = groundOf(look);
  const below = chain.map(([x, y]) => [x, y, ground]);
  paper.pen.globalAlpha = 0.22;
  line(paper, below, paper.colour("--soft"), 5);
  paper.pen.globalAlpha = 0.5;
  const last = chain.length - 1;
  line(paper, [chain[last], below[last]], paper.colour("--soft"), 1, [2, 3]);
  paper.pen.globalAlpha = 1;
}
// The way of the tip up to now, and what is to come, fainter; the desired way in dashes.
function drawTrace(paper, arm, now, look, colour) {
  const last = arm.actual.length - 1;
  const spot = (k) => arm.actual[last].map((side) => at(side, k));
  const goal = (k) => spot(k).map((side, n) => side + look.factor * at(arm.off[last][n], k));
  const all = [...arm.t.keys()];
  paper.pen.globalAlpha = 0.55;
  line(paper, all.map(goal), paper.colour("--ink"), 1, [3, 3]);
  paper.pen.globalAlpha = 0.3;
  line(paper, all.map(spot), paper.colour(colour), 1.4);
  paper.pen.globalAlpha = 1;
  line(paper, all.slice(0, now + 1).map(spot), paper.colour(colour), 1.6);
}
function drawChain(paper, chain, colour) {
  const [ink, rim] = [paper.colour(colour), paper.colour("--paper")];
  const links = chain.slice(1).map((place, k) => [chain[k], place]);
  const depth = ([a, b]) => paper.seen(a)[2] + paper.seen(b)[2];
  const width = Math.max(6, Math.min(11, paper.high / 38));
  for (const link of links.sort((a, b) => depth(a) - depth(b))) {
    const near = paper.seen(link[1])[3];
    line(paper, link, rim, (width + 3) * near);
    line(paper, link, ink, width * near);
  }
  chain.slice(0, -1).forEach((place) => disc(paper, paper.seen(place), 0.42 * width, rim, ink, 2));
}
// A ball as heavy as the payload, if it were of aluminium.
function drawLoad(paper, place, mass) {
  const spot = paper.seen(place);
  const radius = Math.cbrt(mass / (2700 * 4.19)) * paper.scale * spot[3];
  paper.pen.globalAlpha = 0.85;
  disc(paper, spot, Math.max(6, radius), paper.colour("--c6"), paper.colour("--paper"), 1.5);
  paper.pen.globalAlpha = 1;
  const beside = spot[0] + Math.max(6, radius) + 5;
  write(paper, `${short(mass)} kg`, beside, spot[1] + 4, paper.colour("--ink"));
}
// Where the arm should be: thin, dashed, and above the arm, so that nothing hides it.
function drawGhost(paper, ghost) {
  const [ink, rim] = [paper.colour("--ink"), paper.colour("--paper")];
  paper.pen.globalAlpha = 0.8;
  line(paper, ghost, rim, 4);
  paper.pen.globalAlpha = 1;
  line(paper, ghost, ink, 1.8, [6, 4]);
  ghost.slice(1).forEach((place) => disc(paper, paper.seen(place), 2.6, rim, ink, 1.4));
}
