"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const $ = (id) => document.getElementById(id);
const style = getComputedStyle(document.documentElement);
const color = (name) => style.getPropertyValue("--" + name).trim();
const VERDICTS = ["good", "suspect", "bad", "unreadable"];
const name = (row) => row.file.split(/[\\/]/).pop();
const element = (tag, text, className) => {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
};

// Counts and histograms.
const minutes = data.rows.reduce((sum, row) => sum + row.seconds, 0) / 60;
const skeletons = new Set(data.rows.map((row) => row.skeleton)).size;
$("summary").textContent = `${data.clips} clips, ${minutes.toFixed(1)} minutes, ${skeletons} skeletons, ${data.rows.filter((row) => row.twin).length} twins`;
for (const verdict of VERDICTS) {
  const count = data.rows.filter((row) => row.verdict === verdict).length;
  const box = element("div", verdict);
  box.style.borderLeftColor = color(verdict);
  box.prepend(element("b", count));
  $("counts").append(box);
}
function bars(into, entries, finds) {
  const most = Math.max(...entries.map((entry) => entry[1]), 1e-9);
  for (const [label, value, text, title] of entries) {
    const bar = element(finds ? "button" : "div", undefined, "bar");
    bar.title = title || "";
    if (finds) bar.onclick = () => { $("search").value = label; $("verdict").value = ""; list(); $("clips").scrollIntoView(); };
    const fill = element("i");
    fill.style.width = (100 * value) / most + "%";
    const track = element("span");
    track.append(fill);
    bar.append(element("span", label), track, element("span", text));
    into.append(bar);
  }
}
const counts = data.kinds.map((kind) => [kind, data.rows.filter((row) => row.reasons.split(" ").includes(kind.name)).length]);
const met = counts.filter((entry) => entry[1]).sort((a, b) => b[1] - a[1]);
bars($("kinds"), met.map(([kind, count]) => [kind.name, count, `${count} clips`, `${kind.help}; suspect from ${kind.suspect} ${kind.unit}, bad from ${kind.bad}; a click lists the clips`]), true);
if (!met.length) $("kinds").append(element("p", "No clip has a reason.", "note"));
const does = ["stands", "walks", "runs", "jumps", "lies", "other"];
bars($("does"), does.map((label, index) => {
  const seconds = data.rows.reduce((sum, row) => sum + (row.does[index] || 0), 0);
  return [label, seconds, `${(seconds / 60).toFixed(1)} min`];
}));
function histogram(id, edges, value) {
  const canvas = $(id), pen = canvas.getContext("2d");
  const values = data.rows.filter((row) => row.frames && value(row) !== null).map(value);
  const bins = edges.slice(1).map((edge, i) => values.filter((found) => found >= edges[i] && found < edge).length);
  const most = Math.max(...bins, 1), width = canvas.width / bins.length;
  pen.font = "12px system-ui"; pen.textAlign = "center";
  bins.forEach((count, i) => {
    const height = (100 * count) / most;
    pen.fillStyle = color("accent"); pen.fillRect(i * width + 4, 120 - height, width - 8, height);
    pen.fillStyle = color("soft"); pen.fillText(edges[i + 1] === Infinity ? "more" : "<" + edges[i + 1], (i + 0.5) * width, 138);
    if (count) pen.fillText(count, (i + 0.5) * width, 114 - height);
  });
}
histogram("lengths", [0, 1, 2, 4, 8, 16, 32, 64, 128, Infinity], (row) => row.seconds);
histogram("qualities", [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, Infinity], (row) => row.quality);
histogram("speeds", [0, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 2.4, 4, Infinity], (row) => row.speed);

// Moving figures.
function draw(canvas, figure, time, angle) {
  const pen = canvas.getContext("2d"), frames = figure.frames;
  pen.clearRect(0, 0, canvas.width, canvas.height);
  if (!frames.length) return;
  const frame = frames[Math.floor(time * figure.rate) % frames.length];
  if (!figure.box) {
    figure.box = [0, 1, 2].map((axis) => {
      const values = frames.flatMap((f) => f.filter((_, i) => i % 3 === axis));
      return [values.reduce((a, b) => Math.min(a, b), Infinity), values.reduce((a, b) => Math.max(a, b), -Infinity)];
    });
  }
  const [x, y, z] = figure.box, floor = Math.min(figure.floor, y[0]);
  const middle = [(x[0] + x[1]) / 2, (floor + y[1]) / 2, (z[0] + z[1]) / 2];
  const wide = Math.hypot(x[1] - x[0], z[1] - z[0]) + 30, high = y[1] - floor + 30;
  const scale = Math.min(canvas.width / wide, canvas.height / (high + 0.25 * wide));
  const c = Math.cos(angle), s = Math.sin(angle), tilt = 0.22;
  const project = (px, py, pz) => {
    const [dx, dy, dz] = [px - middle[0], py - middle[1], pz - middle[2]];
    const side = c * dx + s * dz, deep = -s * dx + c * dz;
    return [canvas.width / 2 + scale * side, canvas.height / 2 - scale * (dy - tilt * deep)];
  };
  pen.strokeStyle = color("line"); pen.lineWidth = 1;
  for (let step = -4; step <= 4; step++) {
    const reach = wide / 2, at = (step * reach) / 4;
    for (const [a, b] of [[[-reach, at], [reach, at]], [[at, -reach], [at, reach]]]) {
      pen.beginPath();
      pen.moveTo(...project(middle[0] + a[0], figure.floor, middle[2] + a[1]));
      pen.lineTo(...project(middle[0] + b[0], figure.floor, middle[2] + b[1]));
      pen.stroke();
    }
  }
  pen.lineCap = "round"; pen.lineWidth = Math.max(1.5, 4 * scale); pen.strokeStyle = color("accent");
  figure.parents.forEach((parent, joint) => {
    pen.beginPath();
    if (parent === null) {
      // Points without a parent, such as markers.
      const [x, y] = project(...frame.slice(3 * joint, 3 * joint + 3));
      pen.fillStyle = color("accent");
      pen.arc(x, y, 2.5, 0, 7);
      pen.fill();
      return;
    }
    pen.moveTo(...project(...frame.slice(3 * joint, 3 * joint + 3)));
    pen.lineTo(...project(...frame.slice(3 * parent, 3 * parent + 3)));
    pen.stroke();
  });
}
const moving = [];
function figureOf(index) {
  const row = data.rows[index], figure = data.figures[index];
  const box = element("button", undefined, "figure"), canvas = element("canvas");
  canvas.width = 260; canvas.height = 200;
  box.append(canvas, element("span", name(row)), element("small", row.reasons || row.verdict));
  box.title = row.file;
  box.onclick = () => open(index);
  if (figure) moving.push([canvas, figure]);
  return box;
}
for (const part of ["worst", "usual"]) {
  $(part + "-part").hidden = !data[part].length;
  for (const index of data[part]) $(part).append(figureOf(index));
}
$("twins-part").hidden = !data.twins.length;
for (const group of data.twins) {
  const pair = element("div", undefined, "pair");
  const reason = group.map((index) => data.rows[index].twin).find((twin) => twin);
  pair.append(element("b", reason || "twin"), ...group.map(figureOf));
  $("twins").append(pair);
}

// The player of `mocap view`, in its own iframe. A build without the player draws only the joints.
function playerOf({ clip, blocks }) {
  const frame = element("iframe");
  const json = `{"clips":[${clip}]}`.replaceAll("<", "\\u003c");
  const scripts = blocks.map(([id, bytes]) => `<script type="application/octet-stream" id="${id}">${bytes}</` + "script>").join("");
  frame.srcdoc = data.player.replace("{{data}}", () => json).replace("{{blocks}}", () => scripts);
  frame.title = "Player";
  return frame;
}
let shown = null, angle = 0.6, playing = true, at = 0;
function open(index) {
  const row = data.rows[index];
  shown = data.figures[index] || null;
  at = 0;
  $("title").textContent = `${row.file} · ${row.clip}`;
  const played = shown && shown.played;
  $("large").hidden = $("time").hidden = $("play").hidden = !shown || played;
  if (shown) $("time").max = shown.frames.length - 1;
  $("frame").replaceChildren(...(played ? [playerOf(played)] : []));
  const lines = row.defects.map(([kind, from, to, joint, amount]) => `${kind}, frames ${from} to ${to}${joint ? ", " + joint : ""}: ${amount.toPrecision(3)} ${data.kinds.find((k) => k.name === kind).unit}`);
  if (row.error) lines.push(row.error);
  if (row.twin) lines.push(`twin of ${row.of}: ${row.twin}`);
  if (shown && shown.from > 0) lines.push(`the figure begins at frame ${shown.from} of the clip`);
  if (!shown) lines.push(`mocap view "${row.file}" shows the motion, which is not in this page`);
  $("findings").replaceChildren(...lines.map((line) => element("li", line)));
  $("player").showModal();
}
$("play").onclick = () => { playing = !playing; $("play").textContent = playing ? "pause" : "play"; };
$("time").oninput = () => { playing = false; $("play").textContent = "play"; at = $("time").value / shown.rate + 1e-6; };
$("large").onpointermove = (event) => { if (event.buttons) angle += event.movementX / 120; };
$("player").onclose = () => $("frame").replaceChildren();
let last = 0;
function tick(now) {
  const seconds = now / 1000;
  for (const [canvas, figure] of moving) draw(canvas, figure, seconds, 0.6);
  if (shown && !shown.played && $("player").open) {
    if (playing) { at += seconds - last; $("time").value = Math.floor(at * shown.rate) % shown.frames.length; }
    draw($("large"), shown, at, angle);
  }
  last = seconds;
  requestAnimationFrame(tick);
}
requestAnimationFrame(tick);

// The map and the list.
const points = data.rows.map((row, index) => [row, index]).filter(([row]) => row.x !== null);
const extent = (axis) => [Math.min(...points.map(([row]) => row[axis]), 0), Math.max(...points.map(([row]) => row[axis]), 1e-9)];
const [ex, ey] = [extent("x"), extent("y")];
const place = (row) => [20 + (1020 * (row.x - ex[0])) / (ex[1] - ex[0] || 1), 400 - (380 * (row.y - ey[0])) / (ey[1] - ey[0] || 1)];
let matching = new Set();
function drawMap() {
  const pen = $("map").getContext("2d");
  pen.clearRect(0, 0, 1060, 420);
  for (const [row, index] of points) {
    pen.globalAlpha = matching.has(index) ? 0.85 : 0.12;
    pen.fillStyle = color(row.verdict);
    pen.beginPath(); pen.arc(...place(row), 5, 0, 7); pen.fill();
  }
}
$("map").onclick = (event) => {
  const box = $("map").getBoundingClientRect(), scale = 1060 / box.width;
  const [px, py] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
  const near = points.map(([row, index]) => [Math.hypot(place(row)[0] - px, place(row)[1] - py), index]).sort((a, b) => a[0] - b[0])[0];
  if (near && near[0] < 30) { $("search").value = data.rows[near[1]].file; list(); open(near[1]); }
};
const columns = [["file", (r) => r.file], ["verdict", (r) => VERDICTS.indexOf(r.verdict)], ["quality", (r) => r.quality], ["seconds", (r) => r.seconds], ["reasons", (r) => r.reasons], ["twin", (r) => r.twin || ""]];
let order = 2, down = false;
columns.forEach(([label], i) => {
  const head = element("th", label);
  head.onclick = () => { down = order === i ? !down : false; order = i; list(); };
  $("head").append(head);
});
function list() {
  const words = $("search").value.toLowerCase().split(/\s+/).filter(Boolean), verdict = $("verdict").value;
  const found = data.rows.map((row, index) => [row, index]).filter(([row]) => {
    const text = `${row.file} ${row.clip} ${row.reasons} ${row.twin || ""} ${row.of || ""} ${row.verdict}`.toLowerCase();
    return (!verdict || row.verdict === verdict) && words.every((word) => text.includes(word));
  });
  const key = columns[order][1];
  found.sort(([a], [b]) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0) * (down ? -1 : 1));
  matching = new Set(found.map(([, index]) => index));
  const rows = found.slice(0, 300).map(([row, index]) => {
    const line = element("tr"), badge = element("span", row.verdict, "verdict"), cell = element("td");
    badge.style.background = color(row.verdict);
    cell.append(badge);
    line.append(element("td", row.file), cell, element("td", row.quality.toFixed(2)), element("td", row.seconds.toFixed(1)), element("td", row.reasons), element("td", row.twin || ""));
    line.onclick = () => open(index);
    return line;
  });
  $("list").replaceChildren(...rows);
  $("shown").textContent = `${found.length} of ${data.clips} clips${found.length > 300 ? ", the first 300 are listed" : ""}`;
  drawMap();
}
$("search").oninput = $("verdict").onchange = list;
list();
