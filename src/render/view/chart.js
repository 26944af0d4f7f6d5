// Curves over time on a canvas. The curves are drawn once, and a cursor moves over them.

import { short } from "./dom.js";
import { clamp } from "./math.js";

export class Chart {
  constructor(canvas, seek) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.picture = document.createElement("canvas");
    const toTime = (event) => {
      const { left, width } = canvas.getBoundingClientRect();
      seek(clamp((event.clientX - left) / width, 0, 1));
    };
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); toTime(event); });
    canvas.addEventListener("pointermove", (event) => { if (event.buttons) toTime(event); });
  }

  // Draws the rows as curves, from the frame `from` to the frame `to`. Only the first `filled` numbers of a row are
  // known. Labels show `unit` after their numbers.
  show(rows, { filled, colors, unit, from = 0, to = rows[0].length - 1 }) {
    Object.assign(this, { rows, filled, colors, unit, from, to });
    this.drawCurves();
  }

  drawCurves() {
    const { canvas, picture, filled, colors, from, to } = this;
    const rows = this.rows?.map((row) => row.subarray(from, Math.min(filled, to + 1)));
    const frames = to - from + 1;
    const ratio = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (!width || !filled) return;
    const known = rows[0].length;
    for (const surface of [canvas, picture]) Object.assign(surface, { width, height });
    const pen = picture.getContext("2d");
    let [low, high] = [Infinity, -Infinity];
    for (const row of rows) for (const value of row) { if (value < low) low = value; if (value > high) high = value; }
    if (!known) [low, high] = [0, 0];
    if (high - low < 1e-6 * Math.max(1, Math.abs(high))) { low -= 0.5; high += 0.5; }
    const [top, bottom] = [6 * ratio, height - 6 * ratio];
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - top);
    const style = getComputedStyle(document.documentElement);
    pen.strokeStyle = style.getPropertyValue("--rule");
    pen.lineWidth = ratio;
    for (const value of low < 0 && high > 0 ? [low, 0, high] : [low, high]) {
      pen.beginPath();
      pen.moveTo(0, y(value));
      pen.lineTo(width, y(value));
      pen.stroke();
    }
    rows.forEach((row, index) => {
      pen.strokeStyle = colors[index];
      pen.lineWidth = 1.5 * ratio;
      pen.lineJoin = "round";
      pen.beginPath();
      const last = Math.max(1, frames - 1);
      const stretch = Math.max(1, Math.floor(frames / width));
      for (let start = 0; start < row.length; start += stretch) {
        // Draw all values of one pixel column as a line from the lowest to the highest.
        let [least, most] = [row[start], row[start]];
        for (let i = start; i < Math.min(start + stretch, row.length); i++) { least = Math.min(least, row[i]); most = Math.max(most, row[i]); }
        const x = (start / last) * width;
        pen.lineTo(x, y(least));
        if (most !== least) pen.lineTo(x, y(most));
      }
      if (frames === 1 && known) pen.lineTo(width, y(row[0]));
      pen.stroke();
    });
    pen.fillStyle = style.getPropertyValue("--faded");
    pen.font = `${10 * ratio}px system-ui, sans-serif`;
    pen.fillText(`${short(high)}${this.unit}`, 3 * ratio, top + 10 * ratio);
    pen.fillText(`${short(low)}${this.unit}`, 3 * ratio, bottom - 3 * ratio);
  }

  // Moves the cursor to a fraction of the clip's duration.
  point(share) {
    const { canvas, pen, picture } = this;
    if (!picture.width || !canvas.width) return;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(picture, 0, 0);
    pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--ink");
    pen.fillRect(Math.round(share * (canvas.width - 2)), 0, 2, canvas.height);
  }
}
