/** Writers of measured files for the tests, independent of the readers. */

const TYPES = { Uint8Array: 1, Float32Array: 10 } as const;

export interface Tensor {
  shape: number[];
  values: Uint8Array | Float32Array;
}

/** A MERL file of f (theta_h, theta_d, phi_d) -> RGB [1/sr] at the bins' centres [rad]. */
export function merlFile(
  f: (thetaH: number, thetaD: number, phiD: number) => readonly [number, number, number],
): ArrayBuffer {
  const bins = 90 * 90 * 180;
  const file = new ArrayBuffer(12 + 24 * bins);
  const view = new DataView(file);
  [90, 90, 180].forEach((n, k) => {
    view.setInt32(4 * k, n, true);
  });
  const units = [1 / 1500, 1.15 / 1500, 1.66 / 1500];
  for (let bin = 0; bin < bins; bin++) {
    const i = Math.floor(bin / 16200) + 0.5;
    const j = (Math.floor(bin / 180) % 90) + 0.5;
    const k = (bin % 180) + 0.5;
    const value = f((i / 90) ** 2 * (Math.PI / 2), (j * Math.PI) / 180, (k * Math.PI) / 180);
    for (let channel = 0; channel < 3; channel++)
      view.setFloat64(12 + 8 * (channel * bins + bin), value[channel]! / units[channel]!, true);
  }
  return file;
}

/** A tensor file; `claimed` replaces shapes in the header. */
export function tensorFile(
  tensors: Record<string, Tensor>,
  claimed: Record<string, number[]> = {},
): ArrayBuffer {
  const entries = Object.entries(tensors);
  const size = (name: string, { shape }: Tensor) =>
    13 + name.length + 8 * (claimed[name] ?? shape).length;
  const header = 18 + entries.reduce((sum, [name, tensor]) => sum + size(name, tensor), 0);
  const total = entries.reduce((sum, [, { values }]) => sum + values.byteLength, header);
  const bytes = new Uint8Array(total);
  const view = new DataView(bytes.buffer);
  bytes.set(new TextEncoder().encode("tensor_file\0"));
  bytes.set([1, 0], 12);
  view.setUint32(14, entries.length, true);
  let [at, start] = [18, header];
  for (const [name, tensor] of entries) {
    const shape = claimed[name] ?? tensor.shape;
    view.setUint16(at, name.length, true);
    bytes.set(new TextEncoder().encode(name), at + 2);
    at += 2 + name.length;
    view.setUint16(at, shape.length, true);
    view.setUint8(at + 2, TYPES[tensor.values.constructor.name as keyof typeof TYPES]);
    view.setBigUint64(at + 3, BigInt(start), true);
    shape.forEach((n, k) => {
      view.setBigUint64(at + 11 + 8 * k, BigInt(n), true);
    });
    at += 11 + 8 * shape.length;
    const { buffer, byteOffset, byteLength } = tensor.values;
    bytes.set(new Uint8Array(buffer, byteOffset, byteLength), start);
    start += byteLength;
  }
  return bytes.buffer;
}

/** Tensors of an isotropic RGL material with uniform warps and everywhere the same values. */
export function rglTensors(rgb: readonly [number, number, number]): Record<string, Tensor> {
  const [elevations, size] = [4, 5];
  const constant = (shape: number[], value = 1): Tensor => ({
    shape,
    values: new Float32Array(shape.reduce((a, b) => a * b, 1)).fill(value),
  });
  const measured = constant([1, elevations, 3, size, size]);
  measured.values.forEach((_, at) => {
    measured.values[at] = rgb[Math.floor(at / (size * size)) % 3]!;
  });
  const angles = Float32Array.from({ length: elevations }, (_, k) => (k * Math.PI) / 6);
  return {
    description: { shape: [4], values: new TextEncoder().encode("test") },
    phi_i: constant([1], 0),
    theta_i: { shape: [elevations], values: angles },
    ndf: constant([2, size], 3),
    sigma: constant([2, size], 0.5),
    vndf: constant([1, elevations, size, size]),
    jacobian: { shape: [1], values: new Uint8Array([1]) },
    rgb: measured,
  };
}
