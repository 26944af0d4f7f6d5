// Measures the time to unpack files, and to decode poses of a packed clip. Runs in Node and in a browser: no module is
// imported.

/**
 * The least time of ten runs in milliseconds. The clock of a browser is coarse, so a run repeats the work for 20 ms.
 */
function least(work) {
  let found = Infinity;
  for (let run = 0, rounds = 1; run < 10; ) {
    const start = performance.now();
    for (let round = 0; round < rounds; round += 1) work();
    const time = performance.now() - start;
    if (time < 20) {
      rounds *= 2;
      continue;
    }
    found = Math.min(found, time / rounds);
    run += 1;
  }
  return found;
}

/** Milliseconds to unpack every view of a file in a meshopt extension. */
function unpackTime(decoder, { views, bytes }) {
  const outputs = views.map(({ count, byteStride }) => new Uint8Array(count * byteStride));
  return least(() => {
    views.forEach(({ byteOffset, byteLength, count, byteStride, mode, filter }, index) => {
      decoder.decodeGltfBuffer(outputs[index], count, byteStride, bytes.subarray(byteOffset, byteOffset + byteLength), mode, filter);
    });
  });
}

/** Microseconds of a pose at a random tick. */
function poseTime(clip) {
  const pose = new Float32Array(clip.poseLength);
  let state = 1;
  const ticks = Float64Array.from({ length: 20_000 }, () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return (state / 2 ** 32) * clip.duration;
  });
  const sample = () => {
    for (let index = 0; index < ticks.length; index += 1) clip.sample(ticks[index], pose);
  };
  return (1000 * least(sample)) / ticks.length;
}

/** The times of files that meshopt packs and of packed clips, by their names. */
export function decodeTimes({ decoder, mocap, packed, clips }) {
  return {
    unpack: Object.fromEntries(Object.entries(packed).map(([name, file]) => [name, unpackTime(decoder, file)])),
    pose: Object.fromEntries(
      Object.entries(clips).map(([name, bytes]) => {
        const clip = mocap.openClip(bytes);
        const time = poseTime(clip);
        clip.free();
        return [name, time];
      }),
    ),
  };
}
