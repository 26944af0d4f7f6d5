// Draws a file from the front, in parallel projection, and computes the expected size of the figure in the picture.

import { AmbientLight, AnimationMixer, Box3, Color, DirectionalLight, OrthographicCamera, Scene, Vector3, WebGLRenderer } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/** The ratio of the picture's height to the figure's height. */
const MARGIN = 1.25;

const renderer = new WebGLRenderer({ antialias: true });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);

/**
 * Shows `file` at a time. Returns the figure's size in metres, the pixels per metre, and the height of the head above
 * the left foot; NaN if a joint has another name.
 */
window.show = async (file, seconds) => {
  const gltf = await new GLTFLoader().loadAsync(file);
  const mixer = new AnimationMixer(gltf.scene);
  for (const clip of gltf.animations) mixer.clipAction(clip).play();
  mixer.setTime(seconds);

  const scene = new Scene();
  scene.background = new Color("#f4f4f4");
  const light = new DirectionalLight("white", 2.5);
  light.position.set(1, 2, 3);
  scene.add(gltf.scene, light, new AmbientLight("white", 1));
  scene.updateMatrixWorld(true);

  const box = new Box3();
  gltf.scene.traverse((object) => {
    if (!object.isSkinnedMesh) return;
    object.computeBoundingBox();
    box.union(object.boundingBox.clone().applyMatrix4(object.matrixWorld));
  });
  const size = box.getSize(new Vector3());
  const centre = box.getCenter(new Vector3());
  const aspect = innerWidth / innerHeight;
  const height = MARGIN * Math.max(size.y, size.x / aspect);
  const camera = new OrthographicCamera((-height * aspect) / 2, (height * aspect) / 2, height / 2, -height / 2, 0, 4 * size.length());
  camera.position.copy(centre).add(new Vector3(0, 0, 2 * size.length()));
  renderer.render(scene, camera);
  const heightOf = (name) => gltf.scene.getObjectByName(name)?.getWorldPosition(new Vector3()).y;
  return {
    size: size.toArray(),
    pixelsPerMetre: innerHeight / height,
    headOverFoot: heightOf("Head") - heightOf("LeftFoot"),
  };
};

/** The pixels of a picture that differ from its upper left pixel: their number, and the box around them. */
window.measure = async (png) => {
  const picture = await createImageBitmap(await (await fetch(png)).blob());
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  const context = canvas.getContext("2d");
  context.drawImage(picture, 0, 0);
  const { data, width, height } = context.getImageData(0, 0, picture.width, picture.height);
  const found = { pixels: 0, colours: new Set(), left: width, right: -1, top: height, bottom: -1 };
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const at = 4 * (y * width + x);
      const distance = Math.abs(data[at] - data[0]) + Math.abs(data[at + 1] - data[1]) + Math.abs(data[at + 2] - data[2]);
      if (distance < 48) continue;
      found.pixels += 1;
      found.colours.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
      found.left = Math.min(found.left, x);
      found.right = Math.max(found.right, x);
      found.top = Math.min(found.top, y);
      found.bottom = Math.max(found.bottom, y);
    }
  }
  return {
    pixels: found.pixels,
    colours: found.colours.size,
    width: found.right - found.left + 1,
    height: found.bottom - found.top + 1,
  };
};

window.isReady = true;
