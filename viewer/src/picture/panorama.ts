/** Panoramas, and taking the bright lights out of them. */

import { dot } from "./vectors";

/** A picture of linear radiance. */
export interface Picture {
  width: number;
  height: number;
  /** (height, width, 3), the first row at the top. */
  pixels: Float32Array;
}

/** A light that is so small and bright that it is evaluated directly. */
export interface Light {
  direction: readonly [number, number, number];
  /** Irradiance at normal incidence, red, green and blue. */
  power: readonly [number, number, number];
}

/** A picture of all directions without its bright lights: width twice the height, the zenith above. */
export interface LitPanorama {
  panorama: Picture;
  lights: Light[];
}

/** The most bright lights; the shader has arrays of this size. */
export const MOST_LIGHTS = 4;

/** Lights as the shaders read them. */
export function uniformsOf(all: readonly Light[]) {
  const of = (key: keyof Light) => {
    const values = new Float32Array(3 * MOST_LIGHTS);
    values.set(all.flatMap((light) => light[key]));
    return values;
  };
  return { lights: all.length, lightDirections: of("direction"), lightPowers: of("power") };
}

/** A pixel is a bright light if it exceeds the mean by this factor. */
const BRIGHT = 60;

/** Lights of this width are one [cosine]. */
const SAME_LIGHT = Math.cos((5 * Math.PI) / 180);

/** The largest number of half precision, in which the graphics card has a panorama. */
const MOST_RADIANCE = 65504;

/** The panorama without its small bright lights, and these. */
export function withoutLights(panorama: Picture): LitPanorama {
  const { width, height, pixels } = panorama;
  const grey = (at: number) => (pixels[at] + pixels[at + 1] + pixels[at + 2]) / 3;
  let sum = 0;
  let weights = 0;
  for (let y = 0; y < height; y++) {
    const weight = Math.sin((Math.PI * (y + 0.5)) / height);
    for (let x = 0; x < width; x++) sum += weight * Math.min(grey(3 * (y * width + x)), 1e4);
    weights += weight * width;
  }
  const limit = (BRIGHT * sum) / weights;

  const found: { direction: number[]; power: number[]; sum: number[] }[] = [];
  const kept = pixels.slice();
  for (let y = 0; y < height; y++) {
    const theta = (Math.PI * (y + 0.5)) / height;
    const solidAngle = (2 * Math.PI * Math.PI * Math.sin(theta)) / (width * height);
    for (let x = 0; x < width; x++) {
      const at = 3 * (y * width + x);
      const value = grey(at);
      if (value <= limit) continue;
      const phi = (2 * Math.PI * (x + 0.5)) / width;
      const way = [
        Math.sin(theta) * Math.sin(phi),
        Math.sin(theta) * Math.cos(phi),
        Math.cos(theta),
      ];
      let light = found.find((one) => dot(one.direction, way) > SAME_LIGHT);
      if (light === undefined) {
        if (found.length === MOST_LIGHTS) continue; // it stays in the panorama
        light = { direction: way, power: [0, 0, 0], sum: [0, 0, 0] };
        found.push(light);
      }
      for (let k = 0; k < 3; k++) {
        const taken = pixels[at + k] * (1 - limit / value);
        light.power[k] += taken * solidAngle;
        light.sum[k] += way[k] * value * solidAngle;
        kept[at + k] -= taken;
      }
      const length = Math.hypot(...light.sum);
      light.direction = light.sum.map((part) => part / length);
    }
  }
  for (let at = 0; at < kept.length; at++) if (kept[at] > MOST_RADIANCE) kept[at] = MOST_RADIANCE;
  const lights = found.map(({ direction, power }) => ({
    direction: [direction[0], direction[1], direction[2]] as const,
    power: [power[0], power[1], power[2]] as const,
  }));
  return { panorama: { width, height, pixels: kept }, lights };
}
