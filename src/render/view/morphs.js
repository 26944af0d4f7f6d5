// Sliders for the morph targets of a skin.

import { byId, make } from "./dom.js";
import { morphSkin, morphWeights } from "./skin.js";

// A slider goes from 0 to 1 in so many steps.
const SLIDER_STEPS = 100;

export class MorphSliders {
  // `changed` is called when the skin is another.
  constructor(changed) {
    this.changed = changed;
    byId("morph-reset").addEventListener("click", () => this.reset());
  }

  // Shows those of a clip; none where no skin is drawn.
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

  // As the file has them: at rest, or in motion.
  reset() {
    const { clip, skin } = this;
    skin.isHeld = false;
    this.set(clip.morphs ? clip.morphWeights(clip.tick) : skin.morphs.map(({ weight }) => weight));
  }

  // After a picture: the sliders go with the motion.
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
