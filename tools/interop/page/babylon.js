// Runs Babylon in a browser, which loads its meshopt decoder from an address, as on a web site.

import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { ImportMeshAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import { MeshoptCompression } from "@babylonjs/core/Meshes/Compression/meshoptCompression.js";
import { Scene } from "@babylonjs/core/scene.js";
import "@babylonjs/loaders/glTF/2.0/index.js";

/** Babylon counts the frames of every animation at this rate. */
const FRAMES_PER_SECOND = 60;

MeshoptCompression.Configuration = { decoder: { url: "/modules/meshoptimizer/meshopt_decoder.cjs" } };
const engine = new NullEngine();

/**
 * Loads `file`. Returns its bones, and the positions of the named nodes at each time in seconds; or the message of
 * Babylon's error.
 */
window.play = async (file, names, times) => {
  const scene = new Scene(engine);
  // Without this setting, the loader mirrors the whole file under an additional node.
  scene.useRightHandedSystem = true;
  try {
    const { skeletons, animationGroups, transformNodes } = await ImportMeshAsync(file, scene, { pluginExtension: ".glb" });
    const nodeByName = new Map(transformNodes.map((node) => [node.name, node]));
    const nodes = names.map((name) => nodeByName.get(name));
    animationGroups.forEach((group) => group.start(false));
    const places = times.map((seconds) => {
      animationGroups.forEach((group) => group.goToFrame(seconds * FRAMES_PER_SECOND));
      nodes.forEach((node) => node.computeWorldMatrix(true));
      return nodes.map((node) => node.getAbsolutePosition().asArray());
    });
    return { bones: skeletons.map((skeleton) => skeleton.bones.length), places };
  } catch (error) {
    return { refusal: error.message };
  } finally {
    scene.dispose();
  }
};

window.isReady = true;
