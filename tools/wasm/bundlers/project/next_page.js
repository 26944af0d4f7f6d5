"use client";
// A page of Next.js. The server renders the page too, and does not run effects.

import { useEffect } from "react";
import { load } from "mocap-wasm";
import { play } from "../walk.js";

export default function Page() {
  useEffect(() => {
    const { joint, frame } = Object.fromEntries(new URLSearchParams(location.search));
    const start = async () => play(await (await fetch("/walk.bvh")).arrayBuffer(), joint, Number(frame));
    start().then((played) => { window.played = played; }, (error) => { window.played = { error: error.message }; });
  }, []);
  return <p>{typeof load}</p>;
}
