// Creates elements of the page, and formats numbers and colours as text.

import { clamp } from "./math.js";

export const byId = (id) => document.getElementById(id);

// Makes an element with attributes and contents. Text is never parsed as HTML.
export function make(tag, attributes = {}, ...contents) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value);
  }
  element.append(...contents);
  return element;
}

// Saves bytes as a file.
export function save(bytes, name, type) {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// Formats a number with at most four significant digits, without trailing zeros.
export function short(value) {
  if (value === 0 || Math.abs(value) < 5e-5) return "0";
  const digits = clamp(3 - Math.floor(Math.log10(Math.abs(value))), 0, 4);
  return value.toFixed(digits).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "").replace("-", "−");
}

// Formats a time in seconds, with minutes and hours if `longest` needs them: 4.20, 1:04.20, 1:02:04.20.
export function clock(seconds, longest) {
  const hundredths = Math.round(100 * seconds);
  const [minutes, hours] = [Math.floor(hundredths / 6000), Math.floor(hundredths / 360000)];
  const rest = ((hundredths % 6000) / 100).toFixed(2);
  if (longest < 60) return (hundredths / 100).toFixed(2);
  if (longest < 3600) return `${minutes}:${rest.padStart(5, "0")}`;
  return `${hours}:${String(minutes % 60).padStart(2, "0")}:${rest.padStart(5, "0")}`;
}

// The name of a unit with this length in metres, for display after a number.
export function lengthUnit(metres) {
  const known = { m: 1, dm: 0.1, cmu: 0.0254 / 0.45, inch: 0.0254, cm: 0.01, mm: 0.001 };
  const name = Object.keys(known).find((unit) => Math.abs(metres / known[unit] - 1) < 1e-6);
  return name ? ` ${name}` : " file units";
}

export const css = (color, opacity = 1) =>
  `rgba(${Array.from(color, (part) => Math.round(255 * part)).join(",")},${clamp(opacity, 0, 1)})`;
