// Sliders for the morph targets of a skin.

import { byId, make } from "./dom.js";
import { morphSkin, morphWeights } from "./skin.js";

// The steps of a slider from 0 to 1.
const SLIDER_STEPS = 100;

export class MorphSliders {
  // `changed` is called when a slider changes the skin.
  constructor(changed) {
    this.changed = changed;
    byId("morph-reset").addEventListener("click", () => this.reset());
  }

  // Shows the sliders of a clip, or none if its skin is not drawn.
  show(clip) {
    const { skin } = clip ?? {};
    Object.assign(this, { clip, skin: skin || null });
    const morphs = skin ? skin.morphs : [];
    byId("morphs").hidden = !morphs.length;
    if (!morphs.length) return;
    document.querySelector("#morphs summary").textContent = `Morph targets (${morphs.length})`;
    this.inputs = morphs.map(({ name, weight }, index) => make("input", {
      type: "range", min: Math.min(0, weight), max: Math.max(1, weight), step: 1 / SLIDER_STEPS, title: name, oninput: () => this.turn(index),
    }));
    this.outputs = morphs.map(() => make("output", {}));
    byId("morph-list").replaceChildren(...morphs.map(({ name }, index) =>
      make("label", {}, make("span", { title: name }, name), this.inputs[index], this.outputs[index])));
    this.showWeights();
  }

  turn(index) {
    const weights = [...morphWeights(this.skin)];
    weights[index] = Number(this.inputs[index].value);
    this.skin.isHeld = true;
    this.set(weights);
  }

  // Resets the weights to the weights in the file, which are constant or animated.
  reset() {
    const { clip, skin } = this;
    skin.isHeld = false;
    this.set(clip.morphs ? clip.morphWeights(clip.tick) : skin.morphs.map(({ weight }) => weight));
  }

  // Updates the sliders to the motion after each picture.
  follow() {
    if (this.clip?.morphs && this.skin && !this.skin.isHeld && byId("morphs").open) this.showWeights();
  }

  set(weights) {
    morphSkin(this.skin, weights);
    this.showWeights();
    this.changed();
  }

  showWeights() {
    morphWeights(this.skin).forEach((weight, index) => {
      this.inputs[index].value = weight;
      this.outputs[index].textContent = weight.toFixed(2);
    });
  }
}
