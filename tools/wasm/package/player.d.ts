/** The detail of the event `load`. */
export interface MocapPlayerLoad {
  clips: { name: string; seconds: number; frames: number }[];
  /** Seconds of the longest clip. */
  duration: number;
}

/**
 * `<mocap-player src="walk.bvh" character="hero.vrm" speed="1" loop="false" paused theme="dark">`. `src` and `character` are
 * addresses. `page` is the address of `player.html`; the default is the file of the package. Events: `ready`; `load` with a
 * `MocapPlayerLoad`; `error` with a `message`; `timeupdate` with `seconds`, `duration` and `playing`, each in `detail`.
 */
export class MocapPlayer extends HTMLElement {
  play(): void;
  pause(): void;
  readonly paused: boolean;
  /** The duration in seconds. */
  readonly duration: number;
  currentTime: number;
}

declare global {
  interface HTMLElementTagNameMap {
    "mocap-player": MocapPlayer;
  }
}
