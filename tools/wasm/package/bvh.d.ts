/**
 * Loads the small module, which only converts BVH to GLB. The result is the file that `mocap convert walk.bvh walk.glb` writes,
 * except for the name and the hash of the source file.
 *
 * ```js
 * const bvhToGlb = await loadBvh();
 * const glb = bvhToGlb(await file.arrayBuffer());
 * ```
 *
 * @param source The address, the bytes or the module of `mocap_bvh.wasm`; by default the file in the package.
 */
export function loadBvh(source?: string | URL | BufferSource | WebAssembly.Module): Promise<
  (file: string | ArrayBuffer | ArrayBufferView, options?: { /** Whether a mesh shows the skeleton. Default: true. */ skeletonMesh?: boolean }) => Uint8Array
>;
