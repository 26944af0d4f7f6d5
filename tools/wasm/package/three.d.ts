import type { AnimationClip, Loader, LoadingManager, Skeleton } from "three";
import type { ConvertOptions, Diagnostic, Mocap } from "./index.js";

export interface MocapResult {
  skeleton: Skeleton;
  clip: AnimationClip;
  warnings: Diagnostic[];
}

/** Loads motions with the result of three.js's BVHLoader. */
export class MocapLoader extends Loader<MocapResult> {
  constructor(manager?: LoadingManager, mocap?: Mocap);
  animateBonePositions: boolean;
  animateBoneRotations: boolean;
  /** Options of the conversion; `{}` for metres with +Y up. Default: null, the unit and the axes of the file. */
  convert: ConvertOptions | null;
  /** Loads the module. Call it before `parse`; `load` waits for the module. */
  init(): Promise<this>;
  load(
    url: string,
    onLoad: (result: MocapResult) => void,
    onProgress?: (event: ProgressEvent) => void,
    onError?: (error: unknown) => void,
  ): void;
  parse(data: ArrayBuffer | Uint8Array | string, name?: string): MocapResult;
}
