// A page with the hook of the README: it poses the bones, in metres, and puts their lengths back into the unit of the file.

import React, { Suspense, useEffect } from "react";
import { createRoot } from "react-dom/client";
import { Canvas } from "@react-three/fiber";
import { Vector3 } from "three";
import { useMocap, Figure } from "./use_mocap.jsx";

globalThis.React = React;
/** Metres in the unit of the walk, as the CMU collection says. */
const UNIT = 0.0254 / 0.45;

function Probe() {
  const { root, skeleton, clip, mixer } = useMocap("/walk.bvh", { paused: true });
  useEffect(() => {
    const { joint, frame } = Object.fromEntries(new URLSearchParams(location.search));
    const [track] = clip.tracks.filter(({ times }) => times.length > 1);
    mixer.setTime(track.times[frame]);
    root.updateMatrixWorld(true);
    const at = skeleton.bones.find(({ name }) => name === joint).getWorldPosition(new Vector3()).divideScalar(UNIT).toArray();
    window.played = { frameCount: track.times.length, posed: at, mixed: at };
  }, [root, skeleton, clip, mixer]);
  return null;
}

const element = document.body.appendChild(document.createElement("div"));
createRoot(element).render(<Canvas><Suspense><Probe /><Figure url="/walk.bvh" speed={2} /></Suspense></Canvas>);
