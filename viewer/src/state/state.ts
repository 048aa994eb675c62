/** Everything that the page shows, as one immutable value. */

import type { MaterialCards } from "../material/material";
import { preset } from "../material/presets";
import { flag, oneOf, record, text, type Values, within } from "./json";

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

/** Where the camera stands, and how wide the object appears. */
const VIEW = {
  /** Angle about the vertical axis [degrees]. */
  azimuth: within(-180, 180, 20),
  /** Angle above the horizon [degrees]. */
  elevation: within(-10, 85, 18),
  /** Size of the object, 1 fits the picture. */
  zoom: within(0.5, 4, 1),
  /** Angle of the picture's height if the ball around the object fills 80 % of it [degrees]. */
  fov: within(5, 60, 24),
  /** Shift of the object to the right and upwards, in half heights of the picture at zoom 1. */
  pan: (value: unknown): readonly [number, number] => {
    const [along, upward] = Array.isArray(value) ? value : [];
    return [within(-2, 2, 0)(along), within(-2, 2, 0)(upward)];
  },
};

/** A view of a JSON value, within its ranges. */
export const readView = record(VIEW);

/** What a state has beside its materials, with its ranges and first values. */
const FIELDS = {
  /** The material that the cards show. */
  active: oneOf<0 | 1>([0, 1], 0),
  comparison: oneOf(COMPARISONS, "off"),
  /** Share of the picture left of the swipe's edge. */
  edge: within(0, 1, 0.5),
  scale: oneOf(DIFFERENCE_SCALES, 50),
  /** "own" is a mesh that was opened. */
  object: oneOf([...OBJECTS, "own"] as const, "goblet"),
  /** Name of the file of the mesh that was opened last, of the object "own"; or "". */
  mesh: text(""),
  environment: oneOf(ENVIRONMENTS, "studio"),
  /** Name of the file of the panorama that was opened last, of the environment "own"; or "". */
  panorama: text(""),
  /** Rotation of the environment [degrees]. */
  rotation: within(-180, 180, 0),
  /** Exposure [powers of two]. */
  exposure: within(-6, 6, 0),
  view: readView,
  /** The tone curve. */
  tone: oneOf(TONES, "neutral"),
  /** What lies behind the object: "environment", "transparent", or a colour "#rrggbb" (sRGB). */
  background: (value: unknown) =>
    value === "transparent" || /^#[0-9a-f]{6}$/.test(String(value)) ? String(value) : "environment",
  /** Whether the camera goes round the object. */
  turntable: flag,
  /** Whether the plots are unfolded. */
  plots: flag,
  /** Angle of incidence of the plot [degrees]. */
  incidence: within(0, 89, 45),
};

export type State = Values<typeof FIELDS> & { materials: readonly [MaterialCards, MaterialCards] };
export type View = State["view"];
export type ObjectName = State["object"];
export type EnvironmentName = State["environment"];
export type Tone = State["tone"];
export type Comparison = State["comparison"];

/** All but the materials of a JSON value; what is missing or of another kind has its first value. */
export const readFields = record(FIELDS);

export const INITIAL: State = {
  materials: [preset("Vermilion urushi"), preset("Gilding under shellac")],
  ...readFields({}),
};
