/** RGL materials: isotropic BRDFs of Dupuy and Jakob 2018; see Python's `measured.rgl`. */

import { FileError } from "../safetensors";
import type { Direction } from "./half_vector";
import { type Field, readTensorFile } from "./rgl_file";
import { srgbWeights, VISIBLE } from "./spectra";
import { cellAt, type Slices, slicesAt, Warp } from "./warp";

/** Type and number of dimensions of each tensor that every file has. */
const TENSORS: Readonly<Record<string, readonly [Field["type"], number]>> = {
  description: ["u1", 1],
  phi_i: ["f4", 1],
  theta_i: ["f4", 1],
  ndf: ["f4", 2],
  sigma: ["f4", 2],
  vndf: ["f4", 4],
  jacobian: ["u1", 1],
};

/** Least cos theta_o by which f cos theta_o is divided; the data do not vanish at the horizon. */
const LEAST_COSINE = 0.01;

/** A BRDF in the adaptive parameterization: isotropic, reciprocal but for errors. */
export class Rgl {
  readonly isReciprocal = false;
  private readonly elevations: Float32Array;
  private readonly ndf: Float32Array;
  private readonly sigma: Float32Array;
  private readonly hasJacobian: boolean;
  private readonly warp: Warp;
  /** (slices, channels, rows, columns). */
  private readonly measured: Field;
  /** (channels, 3) to linear sRGB. */
  private readonly toRgb: Float64Array;

  /** @throws FileError if a tensor is missing, damaged or out of range, or it is anisotropic. */
  constructor(file: ArrayBuffer) {
    const tensors = readTensorFile(file);
    const isRgb = tensors.has("rgb") && !tensors.has("spectra");
    const colour = isRgb ? "rgb" : "spectra";
    checkStructure(tensors, colour);
    checkValues(tensors, colour);
    checkIsotropic(tensors);
    const floats = (name: string) => fieldOf(tensors, name).values as Float32Array;
    const columnsOf = (name: string) => fieldOf(tensors, name).shape[1] as number;
    this.elevations = floats("theta_i");
    this.ndf = floats("ndf").slice(0, columnsOf("ndf"));
    this.sigma = floats("sigma").slice(0, columnsOf("sigma"));
    this.hasJacobian = fieldOf(tensors, "jacobian").values[0] !== 0;
    const [, , rows = 0, columns = 0] = fieldOf(tensors, "vndf").shape;
    const density = Float64Array.from(floats("vndf"), (value) => Math.max(value, 0));
    this.warp = new Warp(density, rows, columns);
    this.measured = fieldOf(tensors, colour);
    this.toRgb = isRgb
      ? Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1)
      : srgbWeights(floats("wavelengths"));
  }

  /** Linear sRGB [1/sr] for directions above the horizon, never negative. */
  f(wi: Direction, wo: Direction): [number, number, number] {
    const m: Direction = [wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]];
    const [thetaI, thetaM] = [elevation(wi), elevation(m)];
    // Zeros are positive, so that it is 0 along the normal whatever the signs there.
    const across = wi[0] * m[1] - wi[1] * m[0] + 0;
    const azimuth = Math.atan2(across, wi[0] * m[0] + wi[1] * m[1] + 0);
    const xI = Math.sqrt(thetaI / (Math.PI / 2));
    const xM = Math.sqrt(thetaM / (Math.PI / 2));
    const slices = slicesAt(this.elevations, thetaI);
    const at = this.warp.invert(xM, (azimuth + Math.PI) / (2 * Math.PI), slices);
    let scale = 1 / Math.max(wo[2], LEAST_COSINE);
    if (this.hasJacobian) {
      scale *= linear(this.ndf, xM) / (4 * linear(this.sigma, xI));
    }
    const sum: [number, number, number] = [0, 0, 0];
    this.lookedUp(at, slices).forEach((value, channel) => {
      for (let k = 0; k < 3; k++) sum[k] += value * scale * this.toRgb[3 * channel + k];
    });
    return [Math.max(sum[0], 0), Math.max(sum[1], 0), Math.max(sum[2], 0)];
  }

  /** The measured values (channels) at a point of the square. */
  private lookedUp([u, v]: readonly [number, number], slices: Slices): Float64Array {
    const { shape, values } = this.measured;
    const [, , channels = 0, rows = 0, columns = 0] = shape;
    const [column, x] = cellAt(u, columns);
    const [row, y] = cellAt(v, rows);
    const result = new Float64Array(channels);
    for (const [slice, weight] of slices) {
      for (let channel = 0; channel < channels; channel++) {
        const first = ((slice * channels + channel) * rows + row) * columns + column;
        const upper = (1 - x) * values[first] + x * values[first + 1];
        const lower = (1 - x) * values[first + columns] + x * values[first + columns + 1];
        result[channel] += weight * ((1 - y) * upper + y * lower);
      }
    }
    return result;
  }
}

type Tensors = ReadonlyMap<string, Field>;

function fieldOf(tensors: Tensors, name: string): Field {
  const field = tensors.get(name);
  if (!field)
    throw new FileError(`The file has no tensor '${name}', so that it is no RGL material.`);
  return field;
}

function checkStructure(tensors: Tensors, colour: string): void {
  const expected: Record<string, readonly [Field["type"], number]> = {
    ...TENSORS,
    ...(colour === "rgb" ? {} : { wavelengths: ["f4", 1] as const }),
    [colour]: ["f4", 5],
  };
  for (const [name, [type, dimensions]] of Object.entries(expected)) {
    const field = fieldOf(tensors, name);
    if (field.type !== type || field.shape.length !== dimensions)
      throw new FileError(
        `The tensor '${name}' has another type or shape than RGL materials have.`,
      );
  }
  const shape = (name: string) => fieldOf(tensors, name).shape;
  const [phi = 0] = shape("phi_i");
  const [theta = 0] = shape("theta_i");
  const [channels = 0] = colour === "rgb" ? [3] : shape("wavelengths");
  const [measured, vndf] = [shape(colour), shape("vndf")];
  const resolutions = [theta, channels, ...vndf.slice(2), ...measured.slice(3)];
  resolutions.push(...shape("ndf"), ...shape("sigma"));
  const fits =
    phi >= 1 &&
    Math.min(...resolutions) >= 2 &&
    vndf.slice(0, 2).join() === [phi, theta].join() &&
    measured.slice(0, 3).join() === [phi, theta, channels].join() &&
    shape("jacobian").join() === "1";
  if (!fits) throw new FileError("The shapes of the file's tensors do not fit each other.");
}

function checkIsotropic(tensors: Tensors): void {
  const [phi = 0] = fieldOf(tensors, "phi_i").shape;
  const varies = ["ndf", "sigma"].some((name) => {
    const { shape, values } = fieldOf(tensors, name);
    const [, columns = 0] = shape;
    return values.some((value: number, k: number) => value !== values[k % columns]);
  });
  if (phi > 1 || varies)
    throw new FileError(
      `The material is anisotropic (measured at ${phi} azimuths); only isotropic ones can be used.`,
    );
}

function checkValues(tensors: Tensors, colour: string): void {
  const values = (name: string) => fieldOf(tensors, name).values;
  const isSpectral = colour === "spectra";
  const floats = Object.keys(TENSORS).filter((name) => TENSORS[name]?.[0] === "f4");
  for (const name of [...floats, colour, ...(isSpectral ? ["wavelengths"] : [])])
    if (!values(name).every(Number.isFinite))
      throw new FileError(`The tensor '${name}' has numbers that are not finite.`);
  for (const name of ["theta_i", ...(isSpectral ? ["wavelengths"] : [])]) {
    const nodes = values(name);
    if (nodes.some((node: number, k: number) => k > 0 && !(node > nodes[k - 1])))
      throw new FileError(`The tensor '${name}' does not increase.`);
  }
  if (isSpectral) {
    const seen = [...values("wavelengths")].filter((nm) => nm >= VISIBLE[0] && nm <= VISIBLE[1]);
    if (seen.length < 2)
      throw new FileError("The file's wavelengths are outside of visible light.");
  }
  if (!values("sigma").every((value: number) => value > 0))
    throw new FileError("The tensor 'sigma', a projected area, is not positive.");
  if (values("ndf").some((value: number) => value < 0))
    throw new FileError("The tensor 'ndf', a density, is negative.");
  const [, theta = 0, rows = 0, columns = 0] = fieldOf(tensors, "vndf").shape;
  for (let slice = 0; slice < theta; slice++) {
    const part = values("vndf").subarray(slice * rows * columns, (slice + 1) * rows * columns);
    if (!part.some((value: number) => value > 0))
      throw new FileError("The tensor 'vndf' has no density at all for some elevation.");
  }
}

/** The angle from the normal of a vector of any length [rad]. */
function elevation(w: Direction): number {
  return Math.atan2(Math.hypot(w[0], w[1]), w[2]);
}

/** Values at equally spaced nodes over [0, 1], interpolated. */
function linear(values: Float32Array, u: number): number {
  const [cell, place] = cellAt(u, values.length);
  return (1 - place) * values[cell] + place * values[cell + 1];
}
