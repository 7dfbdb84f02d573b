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

const data = embedded();
if (data) start(data);

function start(data) {
  const unpacked = unpacker(data.alphabet);
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
  const { span, cut } = signal === "e" ? { span: errorSpan(values) } : cutSpan(values);
  if (cut) {
    hint.textContent = `Torques from ${cut.map(short).join(" to ")} N·m; peaks are cut off.`;
  }
  const from = Math.min(...shown.map(({ curve }) => curve.t[0]));
  const end = Math.max(...shown.map(({ curve }) => curve.t[curve.t.length - 1]));
  const wide = Math.max(280, Math.min(860, section.clientWidth));
  const high = Math.round(Math.min(400, Math.max(260, 0.55 * wide)));
  const scale = drawAxes(svg, wide, high, [from, end], span, signal === "e");
  const name = signal === "e" ? "error, size [rad]" : "torque [N·m]";
  draw(svg, "text", { class: "name", x: 6, y: 15 }, `${name}, joint ${joint + 1}`);
  drawLines(svg, shown.map(({ curve, at }) => ({ t: curve.t, values: curve[signal][joint],
    colour: `var(--c${at % 8})`, dashed: at % 16 >= 8,
    title: `${curve.name}, seed ${curve.seed}` })), scale);
}
// Exponents of ten of the errors to be seen: four decades at the most.
function errorSpan(values) {
  const most = Math.max(...values);
  const least = Math.max(Math.min(...values), 1e-4 * most, 1e-12);
  return widened(Math.log10(least), Math.log10(Math.max(most, 2e-12)));
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
    const t = Number(slider.value);
    part("now").textContent = `${t.toFixed(2)} s`;
    sides.forEach((select, side) => drawArm(pictures[side], curves[select.value], t, view));
  };
  slider.max = end;
  slider.value = 0;
  for (const control of [slider, ...sides]) control.addEventListener("input", show);
  player(part("play"), slider, () => 1, show);
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
