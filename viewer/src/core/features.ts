/** Inputs of the networks: normalised features of a pair of directions and of a coat. */

/** Smallest cosine to the normal; smaller ones count as it. */
export const MIN_COSINE = 5e-3;

/** Mean and scale of the features of a pair; see Python's `nets.features`. */
const DIRECTION_TABLE: readonly (readonly [number, number])[] = [
  [-3.2, 4.6],
  [0.55, 0.34],
  [0.8, 0.24],
  [0.73, 0.24],
  [0.04, 0.2],
  [-0.78, 0.65],
  [0.0, 0.56],
  [0.47, 0.3],
];

/** The same of the further features of anisotropic networks, which depend on the azimuth. */
const AZIMUTH_TABLE: readonly (readonly [number, number])[] = [
  [-5.0, 4.3],
  [-5.0, 4.3],
  [-0.9, 1.3],
  [-0.9, 1.3],
  [-0.1, 0.3],
  [-0.1, 0.3],
];

/** GGX widths of a surface: one, or two along and across its tangent. */
export type Widths = 1 | 2;

/** Number of features of a pair of directions. */
export const DIRECTION_FEATURES = {
  1: DIRECTION_TABLE.length,
  2: DIRECTION_TABLE.length + AZIMUTH_TABLE.length,
} as const;

/** Mean and scale of the features of a coat. */
const COAT_TABLE: readonly (readonly [number, number])[] = [
  [-1.45, 1.3],
  [0.4, 0.3],
  [1.4, 0.4],
  [0.13, 0.17],
  [0.047, 0.04],
  [-4.0, 1.6],
  [0.08, 0.2],
  [0.75, 0.33],
  [0.14, 0.33],
  [1.2, 0.67],
  [0.5, 0.33],
  [0.37, 0.29],
  [0.0, 0.29],
  [0.09, 0.17],
  [0.0, 0.21],
  [0.9, 0.63],
  [0.52, 0.54],
  [1.15, 0.69],
];

/** Number of features of a coat; the second width has two. */
export const COAT_FEATURES = { 1: COAT_TABLE.length, 2: COAT_TABLE.length + 2 } as const;

const ALL_DIRECTIONS = [...DIRECTION_TABLE, ...AZIMUTH_TABLE];
const DIRECTION_MEANS = Float64Array.from(ALL_DIRECTIONS, ([mean]) => mean);
const DIRECTION_FACTORS = Float64Array.from(ALL_DIRECTIONS, ([, scale]) => 1 / scale);

/** The parameters of one coat for one channel. */
export interface CoatOfChannel {
  /** GGX widths along and across the tangent; networks of one width read the first. */
  alpha: number;
  alphaV: number;
  eta: number;
  albedo: number;
  sigmaT: number;
  g: number;
}

/** What decoder and lobe need of pairs of directions, one array for each quantity. */
export class Pairs {
  /** (count, `DIRECTION_FEATURES`) the decoder's inputs. */
  readonly features: Float64Array;
  /** Both cosines, clamped to [0, 1]. */
  readonly cosI: Float64Array;
  readonly cosO: Float64Array;
  /** Squared length of wi + wo in the surface. */
  readonly across: Float64Array;
  /** Cosine between either direction and the half vector. */
  readonly cosD: Float64Array;
  /** (count, 4) x and y of wi, then of wo; empty for isotropic networks. */
  readonly flat: Float64Array;

  /** @param capacity greatest number of pairs. */
  constructor(
    readonly capacity: number,
    readonly widths: Widths = 1,
  ) {
    const column = () => new Float64Array(capacity);
    this.features = new Float64Array(capacity * DIRECTION_FEATURES[widths]);
    this.flat = new Float64Array(widths === 2 ? 4 * capacity : 0);
    this.cosI = column();
    this.cosO = column();
    this.across = column();
    this.cosD = column();
  }

  /** The pairs of directions (N, 3). */
  static of(wi: ArrayLike<number>, wo: ArrayLike<number>, widths: Widths = 1): Pairs {
    const pairs = new Pairs(wi.length / 3, widths);
    for (let i = 0; i < pairs.capacity; i++) {
      const at = 3 * i;
      pairs.set(i, wi[at], wi[at + 1], wi[at + 2], wo[at], wo[at + 1], wo[at + 2]);
    }
    return pairs;
  }

  /** Set pair `i` to unit vectors. */
  set(i: number, ix: number, iy: number, iz: number, ox: number, oy: number, oz: number): void {
    const x = ix + ox;
    const y = iy + oy;
    const across = x * x + y * y;
    this.across[i] = across;
    this.cosI[i] = Math.min(Math.max(iz, 0), 1);
    this.cosO[i] = Math.min(Math.max(oz, 0), 1);
    const sum = iz + oz;
    this.cosD[i] = Math.min(0.5 * Math.sqrt(across + sum * sum), 1);

    const cosI = Math.max(iz, MIN_COSINE);
    const cosO = Math.max(oz, MIN_COSINE);
    const z = cosI + cosO;
    const squared = across + z * z;
    const length = Math.sqrt(squared);
    const cosD = Math.min(0.5 * length, 1);
    const opposite = 1 - cosD;
    const opposite2 = opposite * opposite;

    const f = this.features;
    const count = DIRECTION_FEATURES[this.widths];
    const at = i * count;
    f[at] = Math.log(across / (z * z) + 1e-6);
    f[at + 1] = Math.sqrt(Math.sqrt(across / squared));
    f[at + 2] = z / length;
    f[at + 3] = cosD;
    f[at + 4] = opposite2 * opposite2 * opposite;
    f[at + 5] = 0.5 * Math.log(cosI * cosO);
    f[at + 6] = Math.log(z);
    f[at + 7] = Math.min(cosI, cosO);
    if (this.widths === 2) {
      f[at + 8] = Math.log((x * x) / (z * z) + 1e-6);
      f[at + 9] = Math.log((y * y) / (z * z) + 1e-6);
      f[at + 10] = Math.log(ix * ix + ox * ox + 1e-3);
      f[at + 11] = Math.log(iy * iy + oy * oy + 1e-3);
      f[at + 12] = ix * ox;
      f[at + 13] = iy * oy;
      this.flat.set([ix, iy, ox, oy], 4 * i);
    }
    for (let k = 0; k < count; k++) {
      f[at + k] = (f[at + k] - DIRECTION_MEANS[k]) * DIRECTION_FACTORS[k];
    }
  }
}

/** Put the features of a coat into `out` at a place. */
export function coatFeatures(
  coat: CoatOfChannel,
  out: Float64Array,
  at: number,
  widths: Widths,
): void {
  const { alpha, eta, albedo, sigmaT, g } = coat;
  const s = (eta - 1) / (eta + 1);
  const m = 1 - Math.exp(-sigmaT);
  const columns = [
    Math.log(alpha),
    alpha,
    eta,
    s,
    s * s,
    Math.log(s * s + 1e-4),
    Math.max(1 - eta * eta, 0),
    m,
    Math.exp(-4 * sigmaT),
    Math.log1p(sigmaT),
    m * albedo,
    m * Math.sqrt(1 - albedo),
    m * g,
    m * g * g,
    m * albedo * g,
    Math.log1p(sigmaT * albedo),
    Math.log1p(sigmaT * (1 - albedo)),
    Math.log1p(sigmaT * (1 - albedo * g)),
  ];
  COAT_TABLE.forEach(([mean, scale], k) => {
    out[at + k] = (columns[k] - mean) / scale;
  });
  if (widths === 2) {
    [Math.log(coat.alphaV), coat.alphaV].forEach((column, k) => {
      const [mean, scale] = COAT_TABLE[k];
      out[at + columns.length + k] = (column - mean) / scale;
    });
  }
}
