// The colours of clips, sides and humanoid bones, and the two themes.

export const PALETTE = [[0.18, 0.42, 0.85], [0.88, 0.42, 0.14], [0.2, 0.62, 0.35], [0.62, 0.36, 0.78], [0.82, 0.27, 0.37], [0.25, 0.6, 0.66]];
export const CHOSEN = [1, 0.78, 0.16];
export const AXIS_COLORS = [[0.85, 0.2, 0.24], [0.2, 0.62, 0.27], [0.2, 0.42, 0.9]];
export const THEMES = {
  light: { background: [0.965, 0.972, 0.984], grid: [0.72, 0.76, 0.82], shadow: 0.5 },
  dark: { background: [0.085, 0.098, 0.13], grid: [0.25, 0.29, 0.36], shadow: 0.75 },
};
const GREY = [0.56, 0.61, 0.7];
const SIDES = { left: PALETTE[0], right: PALETTE[1], middle: GREY };
// In a humanoid, left and right have their usual colours. Hips, spine and head are green, and other joints are grey.
export const BONE_SIDES = { left: PALETTE[0], right: PALETTE[1], middle: PALETTE[2] };
export const NO_BONE = GREY;
// Colours of the angle between two limbs, from 0 to WORST degrees, and of limbs that are not compared.
export const WORST = 10;
export const ERRORS = { least: PALETTE[2], middle: [0.95, 0.76, 0.16], most: [0.85, 0.16, 0.16], none: GREY };
export const AT_REST = [0.05, 0.72, 0.6];
const SURENESS = { sure: 1, likely: 0.6, unsure: 0.3 };

export const mix = (a, b, share) => [0, 1, 2].map((i) => a[i] + (b[i] - a[i]) * share);

// The colour of a humanoid bone. Less confidence makes the colour greyer.
export const boneColor = ({ side, confidence }) => mix(NO_BONE, BONE_SIDES[side], SURENESS[confidence]);

export function errorColor(degrees) {
  const share = Math.min(1, degrees / WORST);
  const { least, middle, most } = ERRORS;
  return share < 0.5 ? mix(least, middle, 2 * share) : mix(middle, most, 2 * share - 1);
}

// The colour of a node. If there are several clips, it is the colour of the clip.
export function sideColor(clip, side, severalClips) {
  if (!severalClips) return SIDES[side];
  return side === "left" ? mix(clip.color, [1, 1, 1], 0.22) : side === "right" ? mix(clip.color, [0, 0, 0], 0.22) : clip.color;
}
