// Finds the data of a glTF or VRM file that the player does not show, for a note beside the file.

/** The largest examined JSON, in bytes. */
const LARGEST_JSON = 64 << 20;

/** The JSON of a .glb, .vrm or .gltf, or null. */
async function gltfOf(file) {
  const head = new DataView(await file.slice(0, 20).arrayBuffer());
  const isBinary = head.byteLength === 20 && head.getUint32(0) === 0x676c5446;
  if (!isBinary && !/\.gltf$/i.test(file.name)) return null;
  const length = isBinary ? head.getUint32(12, true) : file.size;
  if (length > LARGEST_JSON) return null;
  try {
    return JSON.parse(await file.slice(isBinary ? 20 : 0, (isBinary ? 20 : 0) + length).text());
  } catch {
    // The reader has already reported the error.
    return null;
  }
}

/** The note as a sentence, or "". */
export async function notShownOf(file) {
  const gltf = await gltfOf(file);
  if (!gltf || typeof gltf !== "object") return "";
  const { VRM: vrm0, VRMC_vrm: vrm1, VRMC_springBone: springs } = gltf.extensions ?? {};
  const count = (list) => (Array.isArray(list) ? list.length : Object.keys(list ?? {}).length);
  const expressions = count(vrm0?.blendShapeMaster?.blendShapeGroups) || count(vrm1?.expressions?.preset) + count(vrm1?.expressions?.custom);
  const some = (list, is) => Array.isArray(list) && list.some((item) => is(item ?? {}));
  const hasTargets = some(gltf.meshes, ({ primitives }) => some(primitives, ({ targets }) => targets?.length));
  const parts = [
    expressions && `${expressions} expressions`,
    (vrm0?.firstPerson || vrm1?.lookAt) && "look-at",
    (vrm0?.secondaryAnimation?.boneGroups?.length || springs) && "spring bones",
  ].filter(Boolean);
  const sliders = hasTargets ? "Morph targets have sliders, beside the joints." : "";
  if (!parts.length) return sliders;
  const last = parts.pop();
  return `The picture leaves ${parts.length ? `${parts.join(", ")} and ` : ""}${last} still. A saved file of the character keeps this data. ${sliders}`;
}
