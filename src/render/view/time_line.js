// The time line: its visible part, the lanes of several clips, and the contacts of feet.

import { byId, clock, css, make } from "./dom.js";
import { drawContacts } from "./marks.js";
import { clamp } from "./math.js";

// The fewest visible ticks.
const FEWEST = 8;
// The zoom factor of a press or a notch of the wheel.
const CLOSER = 0.5;

export class TimeLine {
  // Shows the time of `player`. `zoomed` is called when the visible part changes.
  constructor(player, zoomed) {
    Object.assign(this, { player, zoomed });
    this.range = [0, 0];
    byId("scrub").addEventListener("input", (event) => { player.play(false); player.seek(Number(event.target.value)); });
    byId("closer").addEventListener("click", () => this.zoom(CLOSER));
    byId("wider").addEventListener("click", () => this.zoom(1 / CLOSER));
    byId("line").addEventListener("wheel", (event) => this.onWheel(event), { passive: false });
    new ResizeObserver(() => player.clip && this.showContacts()).observe(byId("line"));
  }

  get length() { return this.range[1] - this.range[0]; }

  // Shows the whole time, after the clips have changed.
  showAll() {
    this.range = [0, this.player.longest];
    this.show();
  }

  // Multiplies the length of the visible part by a factor. The time `anchor` keeps its position.
  zoom(factor, anchor = this.player.state.time) {
    const { longest, clip } = this.player;
    if (!longest) return;
    const length = clamp(this.length * factor, Math.min(longest, FEWEST / clip.ticksPerSecond), longest);
    const share = this.length ? clamp((anchor - this.range[0]) / this.length, 0, 1) : 0;
    this.move(anchor - share * length, length);
  }

  move(from, length = this.length) {
    const { longest } = this.player;
    const start = clamp(from, 0, longest - length);
    this.range = [start, start + length];
    this.show();
  }

  onWheel(event) {
    if (event.ctrlKey || !this.player.clip) return;
    event.preventDefault();
    const { left, width } = byId("scrub").getBoundingClientRect();
    const share = clamp((event.clientX - left) / width, 0, 1);
    const isAlong = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (isAlong) this.move(this.range[0] + Math.sign(event.deltaX || event.deltaY) * 0.1 * this.length);
    else this.zoom(event.deltaY > 0 ? 1 / CLOSER : CLOSER, this.range[0] + share * this.length);
  }

  // Moves the visible part so that it contains the current time.
  reveal(seconds) {
    const [from, to] = this.range;
    if (seconds < from - 1e-9 || seconds > to + 1e-9) this.move(seconds > to ? seconds : seconds - this.length);
  }

  show() {
    const { player } = this;
    const { longest, clip } = player;
    if (!clip) return;
    const isWhole = this.length >= longest - 1e-9;
    const ticks = this.range.map((seconds) => seconds * clip.ticksPerSecond);
    Object.assign(byId("scrub"), { min: Math.ceil(ticks[0] - 1e-6), max: Math.floor(ticks[1] + 1e-6) });
    byId("wider").disabled = isWhole;
    byId("closer").disabled = this.length <= FEWEST / clip.ticksPerSecond + 1e-9;
    byId("part").hidden = isWhole;
    byId("part").textContent = this.range.map((seconds) => clock(seconds, longest)).join(" – ");
    this.showLanes();
    this.showContacts();
    player.showTime();
    this.zoomed();
  }

  // Draws a line below the time line for each of several clips, with the length of the clip. If there are many clips,
  // the lines are thinner.
  showLanes() {
    const { clips } = this.player.state;
    byId("lanes").classList.toggle("many", clips.length > 2);
    byId("lanes").replaceChildren(...(clips.length < 2 ? [] : clips).map((clip) => {
      const lane = make("span");
      const [from, to] = [0, clip.seconds].map((seconds) => (100 * clamp(seconds - this.range[0], 0, this.length)) / (this.length || 1));
      lane.style.marginLeft = `${from}%`;
      lane.style.width = `${to - from}%`;
      lane.style.background = css(clip.color);
      return lane;
    }));
  }

  showContacts() {
    drawContacts(byId("rests"), this.player.clip, this.range, this.player.state.contacts);
  }
}
