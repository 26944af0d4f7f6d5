// A clip: nodes, their sampled tracks, and forward kinematics, T = J0 L1 J1 L2 ...

// The bytes of an element that holds base64; the text is dropped, because it may be large.
function takeBytes(id) {
  const element = document.getElementById(id);
  const text = element.textContent;
  element.textContent = "";
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

// Rows of the matrix that turns the file's up into +Y.
const TO_Y_UP = {
  "+y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  "-y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
  "+z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  "-y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
  "-z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
  "-z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
  "+x": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
  "-x": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
};

class Clip {
  constructor(description, index) {
    Object.assign(this, description);
    this.index = index;
    this.floats = new Float32Array(takeBytes(description.data).buffer);
    this.world = this.nodes.map(() => null);
    this.children = this.nodes.map(() => []);
    this.nodes.forEach((node, id) => node.parent >= 0 && this.children[node.parent].push(id));
    this.root = Math.max(0, this.nodes.findIndex((node) => node.kind === "joint"));
    this.duration = Math.max(0, this.frames - 1);
    this.seconds = this.duration / this.ticksPerSecond;
    // From the file's world to the page's, which is in metres with +Y up.
    this.shift = [0, 0, 0];
    this.tick = 0;
    this.measure();
    this.pose(0);
  }

  // The value of one of a node's tracks at a tick: `keys` values of `size` numbers from float `at` on.
  value({ at, keys }, size, tick) {
    const position = clamp(tick, 0, keys - 1);
    const before = Math.floor(position);
    const share = position - before;
    const start = at + before * size;
    const a = this.floats.subarray(start, start + size);
    if (share === 0) return a;
    const b = this.floats.subarray(start + size, start + 2 * size);
    return size === 4 ? slerp(a, b, share) : [0, 1, 2].map((i) => a[i] + (b[i] - a[i]) * share);
  }

  translation(id, tick) { return this.value(this.nodes[id].translation, 3, tick); }
  rotation(id, tick) { return this.value(this.nodes[id].rotation, 4, tick); }
  local(id, tick) {
    return compose(this.translation(id, tick), this.rotation(id, tick), this.value(this.nodes[id].scale, 3, tick));
  }

  // Parents stand before their children, so the kinematics is one loop.
  pose(tick) {
    this.tick = tick;
    this.nodes.forEach((node, id) => {
      const local = this.local(id, tick);
      this.world[id] = node.parent < 0 ? local : multiply(this.world[node.parent], local);
    });
  }

  // From the root to the node.
  chain(id) {
    const chain = [];
    for (let node = id; node >= 0; node = this.nodes[node].parent) chain.unshift(node);
    return chain;
  }

  // The matrix of one node alone, at any tick.
  worldAt(id, tick) {
    return this.chain(id).map((node) => this.local(node, tick)).reduce(multiply);
  }

  filePosition(id) { return this.world[id].slice(12, 15); }

  toPage(point) {
    const rows = TO_Y_UP[this.up];
    return add(rows.map((row) => dot(row, point) * this.metresPerUnit), this.shift);
  }

  toFile(point) {
    const rows = TO_Y_UP[this.up];
    const turned = scale(sub(point, this.shift), 1 / this.metresPerUnit);
    return [0, 1, 2].map((axis) => rows.reduce((sum, row, i) => sum + row[axis] * turned[i], 0));
  }

  pagePosition(id) { return this.toPage(this.filePosition(id)); }
  pagePositionAt(id, tick) { return this.toPage(this.worldAt(id, tick).slice(12, 15)); }

  // The root's way without the sway of the hips, for a camera to follow.
  smoothRoot(tick) {
    const half = 0.35 * this.ticksPerSecond;
    let sum = [0, 0, 0];
    for (let i = -4; i <= 4; i++) sum = add(sum, this.pagePositionAt(this.root, clamp(tick + (i * half) / 4, 0, this.duration)));
    return scale(sum, 1 / 9);
  }

  // The size of the figure and the height of the floor, from a few dozen poses.
  measure() {
    this.reach = 0;
    this.floor = Infinity;
    const samples = Math.min(this.frames, 40) || 1;
    for (let sample = 0; sample < samples; sample++) {
      this.pose(Math.round((this.duration * sample) / Math.max(1, samples - 1)));
      const positions = this.nodes.map((_, id) => this.pagePosition(id));
      for (const position of positions) {
        this.floor = Math.min(this.floor, position[1]);
        this.reach = Math.max(this.reach, length(sub(position, positions[this.root])));
      }
    }
    if (!(this.reach > 0)) this.reach = 1;
  }

  // The curves of a joint over all frames: rows of numbers, one row per frame.
  curves(id) {
    if (this.curvesOf === id) return this.cachedCurves;
    const frames = Math.max(1, this.frames);
    const table = (columns, fill) => {
      const rows = Array.from({ length: columns }, () => new Float64Array(frames));
      for (let tick = 0; tick < frames; tick++) fill(tick).forEach((value, column) => { rows[column][tick] = value; });
      return rows;
    };
    let before = [0, 0, 0];
    this.curvesOf = id;
    this.cachedCurves = {
      local: table(3, (tick) => Array.from(this.translation(id, tick))),
      world: table(3, (tick) => this.worldAt(id, tick).slice(12, 15)),
      euler: table(3, (tick) => (before = nearestAngles(before, eulerAngles(this.rotation(id, tick), this.nodes[id].order)))),
      quaternion: table(4, (tick) => Array.from(this.rotation(id, tick))),
    };
    return this.cachedCurves;
  }

  // The angles of a joint at a tick, as its channels give them.
  angles(id, tick) {
    const whole = this.curvesOf === id ? this.cachedCurves.euler.map((row) => row[Math.floor(tick)]) : [0, 0, 0];
    return nearestAngles(whole, eulerAngles(this.rotation(id, tick), this.nodes[id].order));
  }
}
