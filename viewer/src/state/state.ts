/** Everything that the page shows, as one immutable value. */

import type { MaterialCards } from "../material/material";
import { preset } from "../material/presets";

export const OBJECTS = [
  "goblet",
  "ball",
  "caddy",
  "teapot",
  "plate",
  "vase",
  "bowl",
  "sheet",
] as const;
export const ENVIRONMENTS = ["studio", "sky", "room", "own"] as const;
export const TONES = ["neutral", "filmic", "none"] as const;
export const COMPARISONS = ["off", "side", "swipe", "difference"] as const;

/** Largest colour differences (CIELAB) of the difference's colours. */
export const DIFFERENCE_SCALES = [2, 10, 50] as const;

/** "own" is a mesh that was opened. */
export type ObjectName = (typeof OBJECTS)[number] | "own";
export type EnvironmentName = (typeof ENVIRONMENTS)[number];
export type Tone = (typeof TONES)[number];
export type Comparison = (typeof COMPARISONS)[number];

/** Where the camera stands, and how wide the object appears. */
export interface View {
  /** Angle about the vertical axis [degrees]. */
  azimuth: number;
  /** Angle above the horizon [degrees]. */
  elevation: number;
  /** Size of the object, 1 fits the picture. */
  zoom: number;
  /** Angle of the picture's height if the ball around the object fills 80 % of it [degrees]. */
  fov: number;
  /** Shift of the object to the right and upwards, in half heights of the picture at zoom 1. */
  pan: readonly [number, number];
}

export interface State {
  materials: readonly [MaterialCards, MaterialCards];
  /** The material that the cards show. */
  active: 0 | 1;
  comparison: Comparison;
  /** Share of the picture left of the swipe's edge. */
  edge: number;
  /** One of `DIFFERENCE_SCALES`. */
  scale: number;
  object: ObjectName;
  /** Name of the file of the mesh that was opened last, of the object "own"; or "". */
  mesh: string;
  environment: EnvironmentName;
  /** Name of the file of the panorama that was opened last, of the environment "own"; or "". */
  panorama: string;
  /** Rotation of the environment [degrees]. */
  rotation: number;
  /** Exposure [powers of two]. */
  exposure: number;
  /** The tone curve. */
  tone: Tone;
  /** What lies behind the object: "environment", "transparent", or a colour "#rrggbb" (sRGB). */
  background: string;
  view: View;
  /** Whether the camera goes round the object. */
  turntable: boolean;
  /** Whether the plots are unfolded. */
  plots: boolean;
  /** Angle of incidence of the plot [degrees]. */
  incidence: number;
}

export const INITIAL: State = {
  materials: [preset("Vermilion urushi"), preset("Gilding under shellac")],
  active: 0,
  comparison: "off",
  edge: 0.5,
  scale: 50,
  object: "goblet",
  mesh: "",
  environment: "studio",
  panorama: "",
  rotation: 0,
  exposure: 0,
  tone: "neutral",
  background: "environment",
  view: { azimuth: 20, elevation: 18, zoom: 1, fov: 24, pan: [0, 0] },
  turntable: false,
  plots: false,
  incidence: 45,
};

/** The material that the cards show. */
export function activeMaterial(state: State): MaterialCards {
  return state.materials[state.active];
}

/** The state with another material on the cards. */
export function withMaterial(state: State, material: MaterialCards): State {
  const [first, second] = state.materials;
  return { ...state, materials: state.active === 0 ? [material, second] : [first, material] };
}
