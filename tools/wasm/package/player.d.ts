/** What is shown, when it is. */
export interface MocapPlayerLoad {
  clips: { name: string; seconds: number; frames: number }[];
  /** Seconds of the longest clip. */
  duration: number;
}

/**
 * `<mocap-player src="walk.bvh" character="hero.vrm" speed="1" loop="false" paused theme="dark">`. `src` and `character` are
 * addresses; `page` is that of `player.html`, by default the one of the package. Events: `ready`; `load` with a
 * `MocapPlayerLoad`; `error` with a `message`; `timeupdate` with `seconds`, `duration` and `playing`, each in `detail`.
 */
export class MocapPlayer extends HTMLElement {
  play(): void;
  pause(): void;
  readonly paused: boolean;
  /** In seconds. */
  readonly duration: number;
  currentTime: number;
}

declare global {
  interface HTMLElementTagNameMap {
    "mocap-player": MocapPlayer;
  }
}
