/** A sphere of an exported material under three lights and a sky. */

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const samples = Number(new URLSearchParams(location.search).get("samples") ?? 32); // of the sky
const material = await (await fetch("material.glsl")).text();
const file = await (await fetch("material.dds")).arrayBuffer();
const [height, width, , depth] = new Uint32Array(file, 12, 4); // of the texels behind 148 bytes
const table = new THREE.Data3DTexture(new Uint16Array(file, 148), width, height, depth);
table.type = THREE.HalfFloatType;
table.magFilter = table.minFilter = THREE.LinearFilter;
table.needsUpdate = true;

const vertexShader = `
out vec3 place, normal_;
void main() {
  place = position;
  normal_ = normal;
  gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
}`;

const fragmentShader = `${material}
in vec3 place, normal_;
uniform vec3 lights[3], irradiances[3];
uniform int samples;
uniform highp sampler3D table;

vec3 sky(vec3 to) {
  return mix(vec3(0.15, 0.12, 0.1), vec3(0.5, 0.65, 0.9), smoothstep(-0.3, 0.5, to.y));
}

void main() {
  vec3 z = normalize(normal_);
  vec3 x = normalize(abs(z.y) < 0.9 ? vec3(z.z, 0.0, -z.x) : vec3(0.0, -z.z, z.y));
  mat3 frame = mat3(x, cross(z, x), z); // from the surface's frame to the world
  vec3 wi = normalize(cameraPosition - place) * frame;
  vec3 radiance = vec3(0.0);
  for (int i = 0; i < 3; i++) {
    vec3 wo = lights[i] * frame;
    radiance += urushi_f(wi, wo, table) * max(wo.z, 0.0) * irradiances[i];
  }
  vec3 reflected = vec3(0.0);
  for (int i = 0; i < samples; i++) { // points of the R3 sequence (Roberts 2018)
    UrushiSample drawn = urushi_sample(wi, fract(0.5 + float(i) * vec3(0.8191725, 0.6710436, 0.5497005)));
    vec3 wo = drawn.direction;
    if (drawn.density > 0.0) reflected += urushi_f(wi, wo, table) * max(wo.z, 0.0) / drawn.density * sky(frame * wo);
  }
  gl_FragColor = vec4(radiance + reflected / float(max(samples, 1)), 1.0);
  #include <colorspace_fragment>
}`;

const uniforms = {
  lights: { value: [[1, 2, 2], [-3, 1, 1], [2, -1, 0.5]].map((to) => new THREE.Vector3(...to).normalize()) },
  irradiances: { value: [[1.2, 1.2, 1.2], [0.3, 0.4, 0.7], [0.8, 0.5, 0.3]].map((e) => new THREE.Vector3(...e)) },
  samples: { value: samples },
  table: { value: table },
};
const renderer = new THREE.WebGLRenderer({ antialias: true });
const camera = new THREE.PerspectiveCamera(35, 1, 0.1, 100); // the angle is vertical
camera.position.z = 4;
const scene = new THREE.Scene();
const sphere = new THREE.SphereGeometry(1, 256, 128);
scene.add(new THREE.Mesh(sphere, new THREE.ShaderMaterial({ vertexShader, fragmentShader, uniforms })));
document.body.append(renderer.domElement);

function draw() {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  renderer.render(scene, camera);
  document.body.dataset.drawn = "yes";
}
new OrbitControls(camera, renderer.domElement).addEventListener("change", draw);
addEventListener("resize", draw);
draw();
