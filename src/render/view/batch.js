// Instances of one shape for a renderer. Each has the numbers from, to, width, red, green, blue.

export const INSTANCE = 10;

export class Batch {
  constructor() {
    this.numbers = new Float32Array(INSTANCE * 256);
    this.count = 0;
  }

  clear() { this.count = 0; }

  add(from, to, width, color) {
    const start = this.count * INSTANCE;
    if (start + INSTANCE > this.numbers.length) {
      const larger = new Float32Array(this.numbers.length * 2);
      larger.set(this.numbers);
      this.numbers = larger;
    }
    this.numbers.set(from, start);
    this.numbers.set(to, start + 3);
    this.numbers[start + 6] = width;
    this.numbers.set(color, start + 7);
    this.count++;
  }

  at(index) {
    const number = this.numbers.subarray(index * INSTANCE, (index + 1) * INSTANCE);
    return { from: number.subarray(0, 3), to: number.subarray(3, 6), width: number[6], color: number.subarray(7, 10) };
  }
}
