// Written by `python viewer/formulas.py` from the formulas of Python. Do not edit it.

/** A direction, z the normal. */
export interface Vector {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

/** Of `urushi.checks` of Python. */
export const CHECKS = { AIR: 1.000277, ETA_RANGE: [0.5, 3], MIN_ALPHA: 0.01, MIN_INDEX_STEP:
  0.0009999, TRAINED_G: [-0.8, 0.9] } as const;

/** Of `urushi.core.albedos` of Python. */
export const ALBEDOS = { ROUGHNESSES: 16, COSINES: 48, TOTAL_CELLS: 24, COARSE: [20, 40], FINE: [28,
  57] } as const;

/** Of `urushi.core.appearance` of Python. */
export const APPEARANCE = { WI: [0.6, 0, 0.8], WO: [0, 0.6, 0.8] } as const;

/** Of `urushi.core.facets` of Python. */
export const FACETS = { MIRROR: 100000000 } as const;

/** Of `urushi.core.quadrature` of Python. */
export const QUADRATURE = { POLAR_NODES: 48, EDGE_NODES: 192, AZIMUTH_NODES: 16, MIN_TANGENT: 1e-05
  } as const;

/** Of `urushi.core.stretched` of Python. */
export const STRETCHED = { FACTORS: 5 } as const;

/** Of `urushi.core.table` of Python. */
export const TABLE = { SHAPE: [96, 32, 8], MIN_LOG: -25, MAX_LOG: 16, MIN_COSINE: 0.005 } as const;

/** Of `urushi.material.albedo_rule` of Python. */
export const ALBEDO_RULE = { COSINES: { 1: [1, 0.98, 0.925, 0.84, 0.735, 0.62, 0.51, 0.4, 0.315,
  0.24, 0.175, 0.13, 0.09, 0.04, 0.013], 2: [1, 0.95, 0.84, 0.7, 0.51, 0.36, 0.24, 0.15, 0.09] },
  AZIMUTHS: { 1: [0], 2: [0, 0.7853981633974483, 1.5707963267948966] }, NODES: { 1: [24, 4, 0.001,
  0.0002], 2: [18, 8, 1, 0.0002] } } as const;

/** Of `urushi.material.energy` of Python. */
export const ENERGY = { MARGIN: 0.0005, LEAST_ALBEDO: 1e-06, LEAST_REST: 0.005, NO_FACTOR: 0.999,
  ROUNDS: 5, FACETS: 512, ROUGH_GAIN: 0.003 } as const;

/** Of `urushi.material.layer` of Python. */
export const LAYER = { DEEPEST: 12 } as const;

/** Of `urushi.nets.basis` of Python. */
export const BASIS = { EMPTY_GAIN: -100 } as const;

/** Of `urushi.nets.features` of Python. */
export const FEATURES = { COAT_FEATURES: { 1: 18, 2: 20 } } as const;

/** Of `urushi.nets.layerer` of Python. */
export const LAYERER = { LEAST_GAIN: -12 } as const;

/** Of `urushi.nets.lobe` of Python. */
export const LOBE = { NO_LOBE: [1, 0, 0, 0, 1.5, 0], LOBE_FEATURES: { 1: 6, 2: 8 }, NUMBERS: { 1:
  ["alpha", "normal", "grazing", "exact", "eta", "k"], 2: ["alpha_u", "normal", "grazing", "exact",
  "eta", "k", "alpha_v"] }, COSINES: [1, 0.5, 0.2] } as const;

/** Of `urushi.nets.mlp` of Python. */
export const MLP = { POLYNOMIALS: { smoothstep: [2, [0.375, -0.03125]], silu7: [5.75, [0.225729,
  -0.010473, 0.0002924521977775268, -3.1043713096403e-06]] } } as const;

/** Of `urushi.nets.proposal` of Python. */
export const PROPOSAL = { ALPHAS: [0.04, 0.12, 0.3], TERMS: 8, LARGEST_STRETCH: 1.25 } as const;

/** Schlick's term of factors at normal and at grazing incidence (Schlick 1994). */
export function schlick(normal: number, grazing: number, cosine: number): number {
    const away = 1 - cosine;
    const away2 = away * away;
    const fifth = away2 * away2 * away;
    const fresnel = normal * (1 - fifth) + grazing * fifth;
    return fresnel;
}

/** Unpolarised reflectance of a smooth surface of index eta - i k (PBRT v3, 8.2.1). */
export function fresnel(cosine: number, eta: number, k: number): number {
    const cos2 = cosine * cosine;
    const sin2 = 1 - cos2;
    const difference = (eta - 1) * (eta + 1) - k * k + cos2;
    const size = Math.sqrt(difference * difference + 4 * (eta * eta) * (k * k));
    const root = Math.sqrt(0.5 * Math.max(size + difference, 0));
    const imaginary2 = 0.5 * Math.max(size - difference, 0);
    const less = root - cosine;
    const more = root + cosine;
    const across = (less * less + imaginary2) / (more * more + imaginary2);
    const product = root * cosine;
    const far = imaginary2 * cos2 + 1e-12;
    const third = product - sin2;
    const fourth = product + sin2;
    const parallel = (third * third + far) / (fourth * fourth + far);
    return 0.5 * across * (1 + parallel);
}

/** Cosine between either direction and the half vector. */
export function facetCosine(wiX: number, wiY: number, wiZ: number, woX: number, woY: number, woZ:
    number): number {
    const halfX = wiX + woX;
    const halfY = wiY + woY;
    const halfZ = wiZ + woZ;
    const cosFacet = Math.min(0.5 * Math.sqrt(halfX * halfX + halfY * halfY + halfZ * halfZ), 1);
    return cosFacet;
}

/** Albedo and optical depth of a medium of thickness 1 by its appearance. */
export function medium(color: number, body: number, bodyColor: number, g: number, out: Float64Array,
    at: number): void {
    const reflected = Math.min(Math.max(bodyColor, 0), 1);
    const opaque = Math.min(Math.max(body, 0), 0.99);
    const linear = 1.139 + 1.17 * reflected;
    const s = (linear - Math.sqrt(linear * linear - 0.556 * (1 - reflected))) / 0.278;
    const albedo = (1 - s * s) / (1 - g * s * s);
    const pigment = 1.3333333333333333 * opaque / (1 - opaque) / (1 - albedo * g);
    const depth = Math.abs(0.5 * Math.log(Math.min(Math.max(color, 1e-06), 1))) + pigment;
    out[at] = albedo * (pigment / Math.max(depth, 1e-06));
    out[1 + at] = depth;
}

/** Directions wi and wo of the coordinates of a table of f. */
export function nodeDirections(u: number, v: number, w: number, out: Float64Array, at: number): void
    {
    const cosH = 1 / Math.sqrt(1 + Math.max(Math.exp(-11.512925464970229 + u * 18.420680743952367) -
        1e-05, 1e-09));
    const sinH = Math.sqrt(Math.max(Math.exp(-11.512925464970229 + u * 18.420680743952367) - 1e-05,
        1e-09)) * cosH;
    const cosD = 1 - v * v;
    const sinD = Math.sqrt(Math.max(1 - cosD * cosD, 0));
    const both = sinH * sinD;
    const cosPhi = (both > 1e-12 ? (1 - (1 - w) * (1 - w)) * Math.min(cosH * cosD, both) /
        Math.max(both, 1e-12) : w);
    const acrossX = cosPhi * cosH * sinD;
    const acrossY = Math.sqrt(Math.max(1 - cosPhi * cosPhi, 0)) * sinD;
    const acrossZ = -1 * cosPhi * sinH * sinD;
    out[at] = sinH * cosD + acrossX;
    out[1 + at] = acrossY;
    out[2 + at] = cosH * cosD + acrossZ;
    out[3 + at] = sinH * cosD - acrossX;
    out[4 + at] = -1 * acrossY;
    out[5 + at] = cosH * cosD - acrossZ;
}

/** Albedo, at the normal, of a coat over a Lambertian reflectance, its surface included. */
export function coatedColor(eta: number, albedo: number, sigmaT: number, g: number, reflectance:
    number): number {
    const keptInside = Math.max(1 - 1 / (eta * eta), 0);
    const enteringAbsorption = (1.15 + 0.8500000000000001 * albedo) * (sigmaT - sigmaT * albedo);
    const enteringScattering = (1.15 + 0.8500000000000001 * albedo) * 0.5 * (sigmaT * albedo) * (1 -
        g);
    const enteringRoot = Math.sqrt(enteringAbsorption * (enteringAbsorption + enteringScattering +
        enteringScattering) + 1e-06);
    const enteringFaint = Math.exp(-2 * enteringRoot);
    const enteringDecay = enteringRoot * (1 + enteringFaint) / (1 - enteringFaint);
    const diffuseAbsorption = 2 * (sigmaT - sigmaT * albedo);
    const diffuseScattering = sigmaT * albedo * (1 - g);
    const diffuseRoot = Math.sqrt(diffuseAbsorption * (diffuseAbsorption + diffuseScattering +
        diffuseScattering) + 1e-06);
    const diffuseFaint = Math.exp(-2 * diffuseRoot);
    const diffuseDecay = diffuseRoot * (1 + diffuseFaint) / (1 - diffuseFaint);
    return (eta - 1) / (eta + 1) * ((eta - 1) / (eta + 1)) + (1 - (eta - 1) / (eta + 1) * ((eta - 1)
        / (eta + 1))) * ((1 - keptInside) * ((enteringScattering - reflectance * (enteringAbsorption
        + enteringScattering - enteringDecay)) / (enteringAbsorption + enteringScattering -
        reflectance * enteringScattering + enteringDecay)) / (1 - keptInside * ((diffuseScattering -
        reflectance * (diffuseAbsorption + diffuseScattering - diffuseDecay)) / (diffuseAbsorption +
        diffuseScattering - reflectance * diffuseScattering + diffuseDecay))));
}

/** Albedo of light that facets reflect more than once (Kulla and Conty 2017). */
export function multipleAlbedo(fresnelMean: number, seenMean: number): number {
    return fresnelMean * fresnelMean * seenMean / (1 - fresnelMean * (1 - seenMean));
}

/** Coordinates in a table of f by the stretch s^2, and factors of the azimuth. */
export function stretchedCoordinates(stretch2: number, wiX: number, wiY: number, wiZ: number, woX:
    number, woY: number, woZ: number, out: Float64Array, at: number): void {
    const stretchedZ2 = Math.max((wiZ + woZ) * (wiZ + woZ), 1e-18);
    const stretchedAcross = (wiX + woX) * (wiX + woX) * stretch2 + (wiY + woY) * (wiY + woY) /
        stretch2;
    const apartAcross = (wiX - woX) * (wiX - woX) + (wiY - woY) * (wiY - woY);
    const stretchedSize = stretchedAcross + 1e-05 * stretchedZ2;
    const apartSize = apartAcross + 4e-05;
    const cos2Psi = ((wiX + woX) * (wiX + woX) * stretch2 - (wiY + woY) * (wiY + woY) / stretch2) /
        stretchedSize;
    const cos2P = ((wiX - woX) * (wiX - woX) - (wiY - woY) * (wiY - woY)) / apartSize;
    const psiSeen = stretchedAcross / stretchedSize;
    const pSeen = apartAcross / apartSize;
    const z2 = Math.max((wiZ + woZ) * (wiZ + woZ), 1e-18);
    const squared = (wiX + woX) * (wiX + woX) + (wiY + woY) * (wiY + woY) + z2;
    const cosD = Math.min(0.5 * Math.sqrt(squared), 1);
    const across = (wiX + woX) * (wiX + woX) + (wiY + woY) * (wiY + woY);
    out[at] = (Math.log(stretchedAcross / stretchedZ2 + 1e-05) - (-11.512925464970229)) *
        0.05428681023790647;
    out[1 + at] = Math.sqrt(1 - cosD);
    out[2 + at] = 1 - Math.sqrt(1 - Math.min(0.5 * Math.abs(wiZ - woZ) / Math.max(Math.min(0.5 *
        (wiZ + woZ), Math.sqrt(across / squared * ((1 - cosD) * (1 + cosD)))), 1e-09), 1));
    out[3 + at] = cos2Psi;
    out[4 + at] = cos2P;
    out[5 + at] = 2 * cos2Psi * cos2Psi - psiSeen * psiSeen;
    out[6 + at] = 2 * cos2P * cos2P - pSeen * pSeen;
    out[7 + at] = cos2Psi * cos2P;
}

/** The layerer's inputs of a coat. */
export function coatFeatures(alphaU: number, alphaV: number, eta: number, albedo: number, sigmaT:
    number, g: number, out: Float64Array, at: number): void {
    const s = (eta - 1) / (eta + 1);
    const s2 = s * s;
    const m = 1 - Math.exp(-1 * sigmaT);
    out[at] = (Math.log(alphaU) - (-1.45)) * 0.7692307692307692;
    out[1 + at] = (alphaU - 0.4) * 3.3333333333333335;
    out[2 + at] = (eta - 1.4) * 2.5;
    out[3 + at] = (s - 0.13) * 5.88235294117647;
    out[4 + at] = (s2 - 0.047) * 25;
    out[5 + at] = (Math.log(s2 + 0.0001) - (-4)) * 0.625;
    out[6 + at] = (Math.max(1 - eta * eta, 0) - 0.08) * 5;
    out[7 + at] = (m - 0.75) * 3.0303030303030303;
    out[8 + at] = (Math.exp(-4 * sigmaT) - 0.14) * 3.0303030303030303;
    out[9 + at] = (Math.log1p(sigmaT) - 1.2) * 1.4925373134328357;
    out[10 + at] = (m * albedo - 0.5) * 3.0303030303030303;
    out[11 + at] = (m * Math.sqrt(1 - albedo) - 0.37) * 3.4482758620689657;
    out[12 + at] = m * g * 3.4482758620689657;
    out[13 + at] = (m * g * g - 0.09) * 5.88235294117647;
    out[14 + at] = m * albedo * g * 4.761904761904762;
    out[15 + at] = (Math.log1p(sigmaT * albedo) - 0.9) * 1.5873015873015872;
    out[16 + at] = (Math.log1p(sigmaT * (1 - albedo)) - 0.52) * 1.8518518518518516;
    out[17 + at] = (Math.log1p(sigmaT * (1 - albedo * g)) - 1.15) * 1.4492753623188408;
    out[18 + at] = (Math.log(alphaV) - (-1.45)) * 0.7692307692307692;
    out[19 + at] = (alphaV - 0.4) * 3.3333333333333335;
}

/** The networks' inputs of a lobe, by its reflectances at `LOBE.COSINES`. */
export function lobeFeatures(alphaU: number, alphaV: number, first: number, second: number, third:
    number, out: Float64Array, at: number): void {
    const meanFresnel = (first + second + third) * 0.3333333333333333;
    const seen = meanFresnel / (meanFresnel + 0.01);
    out[at] = (seen * Math.log(alphaU) - (-0.9)) * 0.9090909090909091;
    out[1 + at] = (seen * alphaU - 0.22) * 3.3333333333333335;
    out[2 + at] = (first - 0.45) * 2.5;
    out[3 + at] = (second - 0.47) * 2.5;
    out[4 + at] = (third - 0.55) * 2.857142857142857;
    out[5 + at] = (Math.log(meanFresnel + 0.01) - (-1.5)) * 0.6666666666666666;
    out[6 + at] = (seen * Math.log(alphaV) - (-0.9)) * 0.9090909090909091;
    out[7 + at] = (seen * alphaV - 0.22) * 3.3333333333333335;
}

/** Weights of a proposal by `TERMS` of the code, its overlaps and its lobe's numbers. */
export function proposalWeights(terms: ArrayLike<number>, overlaps: ArrayLike<number>, numbers:
    ArrayLike<number>, cosine: number, passed: number, out: Float64Array, at: number): void {
    const raised = Math.max(cosine, 0.005);
    const width = Math.sqrt(numbers[0] * numbers[6]);
    const width2 = width * width;
    const logWidth = Math.log(width);
    const toFacet = raised + 0.5 * width * (1 - raised);
    const away0 = (logWidth - (-0.629)) * 2.4937655860349124;
    const spread0 = Math.exp(1.305 - away0 * away0);
    const away1 = (logWidth - (-0.28)) * 2.6246719160104988;
    const spread1 = Math.exp(1.762 - away1 * away1);
    const top = (schlick(numbers[1], numbers[2], toFacet) + numbers[3] * fresnel(toFacet,
        numbers[4], numbers[5])) * (1 - 0.4 * width2) / ((1 + width2) * (1 + spread0 + spread1));
    const logCosine = Math.log(Math.max(cosine, 0.005));
    const energy0 = passed * Math.exp(Math.min(terms[0] + terms[4] * logCosine,
        1.3862943611198906));
    const energy1 = passed * Math.exp(Math.min(terms[1] + terms[5] * logCosine,
        1.3862943611198906));
    const energy2 = passed * Math.exp(Math.min(terms[2] + terms[6] * logCosine,
        1.3862943611198906));
    const energy3 = passed * Math.exp(Math.min(terms[3] + terms[7] * logCosine,
        1.3862943611198906));
    const alone0 = energy0 - overlaps[0] * energy1;
    const part0 = 0.5 * (alone0 + Math.sqrt(alone0 * alone0 + 0.001 * energy0 * energy0 + 1e-12));
    const alone1 = energy1 - overlaps[1] * energy2;
    const part1 = 0.5 * (alone1 + Math.sqrt(alone1 * alone1 + 0.001 * energy1 * energy1 + 1e-12));
    const alone2 = energy2 - overlaps[2] * energy3;
    const part2 = 0.5 * (alone2 + Math.sqrt(alone2 * alone2 + 0.001 * energy2 * energy2 + 1e-12));
    const unitSum = 0.98 / (top + part0 + part1 + (part2 + top * spread0) + (energy3 + top *
        spread1) + 1e-12);
    const weight0 = top * unitSum;
    const weight1 = part0 * unitSum;
    const weight2 = part1 * unitSum;
    const weight3 = (part2 + top * spread0) * unitSum;
    out[at] = weight0;
    out[1 + at] = weight1;
    out[2 + at] = weight2;
    out[3 + at] = weight3;
    out[4 + at] = 1 - (weight0 + weight1 + weight2 + weight3);
}

/** The share of light that passes the topmost interface, for a direction. */
export function transmittance(alphaU: number, alphaV: number, factor: number, eta: number, k:
    number, wX: number, wY: number, wZ: number): number {
    const spread2 = Math.max(alphaU * wX * (alphaU * wX) + alphaV * wY * (alphaV * wY), 1e-09);
    const index = (k > 0 ? 1 : eta);
    const thinner = Math.max(Math.min(index, 1), 0.001);
    const above = Math.max(wZ, 0.005);
    const critical2 = Math.max(1 - thinner * thinner, 0);
    const beyond = above - Math.sqrt(critical2);
    const rootBeyond = Math.sqrt(beyond * beyond + spread2);
    const highBeyond = 0.5 * (Math.abs(beyond) + rootBeyond);
    const rampBeyond = (beyond > 0 ? highBeyond : 0.25 * spread2 / highBeyond);
    const rootAll = Math.sqrt(above * above + spread2);
    const highAll = 0.5 * (Math.abs(above) + rootAll);
    const rampAll = (above > 0 ? highAll : 0.25 * spread2 / highAll);
    const perIndex = 1 / (thinner * thinner);
    const straight2 = (above * above - critical2) * perIndex;
    const blur2 = 4 * spread2 * critical2 * perIndex * perIndex + 1e-12;
    const rootInside = Math.sqrt(straight2 * straight2 + blur2);
    const highInside = 0.5 * (Math.abs(straight2) + rootInside);
    const rampInside = (straight2 > 0 ? highInside : 0.25 * blur2 / highInside);
    const inside = Math.sqrt(Math.min(rampInside, 1));
    const across = above + thinner * inside;
    const along = thinner * above + inside;
    const transmittance = 2 * thinner * above * inside * (1 / (across * across) + 1 / (along *
        along)) * (rampBeyond * rootAll) / (rootBeyond * rampAll);
    return (1 > index ? 1 - factor * (1 - transmittance) : 1);
}

/** The lobe [1/sr] of reflectance 1. */
export function lobeShape(alphaU: number, alphaV: number, wiX: number, wiY: number, wiZ: number,
    woX: number, woY: number, woZ: number): number {
    const aboveI = Math.max(wiZ, 0);
    const aboveO = Math.max(woZ, 0);
    const halfX = wiX + woX;
    const halfY = wiY + woY;
    const halfZ = aboveI + aboveO;
    const halfXy2 = halfX * halfX + halfY * halfY;
    const halfZ2 = halfZ * halfZ;
    const alpha2 = alphaU * alphaV;
    const uOverV = alphaU / alphaV;
    const vOverU = alphaV / alphaU;
    const ratio = (halfXy2 + halfZ2) / (halfX * halfX * vOverU + halfY * halfY * uOverV + alpha2 *
        halfZ2 + 1e-18);
    const maskingI = aboveI + Math.sqrt(alpha2 * (wiX * wiX * uOverV + wiY * wiY * vOverU) + aboveI
        * aboveI);
    const maskingO = aboveO + Math.sqrt(alpha2 * (woX * woX * uOverV + woY * woY * vOverU) + aboveO
        * aboveO);
    const lobeShape = alpha2 / 3.141592653589793 * (ratio * ratio) / (maskingI * maskingO);
    return lobeShape;
}

/** Facet normal, of any length, that is visible from wi (Dupuy and Benyoub 2023). */
export function visibleNormal(alphaU: number, alphaV: number, wiX: number, wiY: number, wiZ: number,
    u1: number, u2: number): Vector {
    const wideX = alphaU * wiX;
    const wideY = alphaV * wiY;
    const wideZ = wiZ;
    const wideSize = Math.sqrt(wideX * wideX + wideY * wideY + wideZ * wideZ);
    const capX = wideX / wideSize;
    const capY = wideY / wideSize;
    const capZ = wideZ / wideSize;
    const height = (1 - u2) * (1 + capZ) - capZ;
    const phi = 6.283185307179586 * u1;
    const radius = Math.sqrt(Math.max(1 - height * height, 0));
    const facetX = alphaU * (radius * Math.cos(phi) + capX);
    const facetY = alphaV * (radius * Math.sin(phi) + capY);
    const facetZ = height + capZ;
    return { x: facetX, y: facetY, z: facetZ };
}

/** Density [1/sr] of light mirrored by visible normals, and then up. */
export function reflectionPdf(alphaU: number, alphaV: number, wiX: number, wiY: number, wiZ: number,
    woX: number, woY: number, woZ: number): number {
    const halfX = wiX + woX;
    const halfY = wiY + woY;
    const halfXy2 = halfX * halfX + halfY * halfY;
    const alpha2 = alphaU * alphaV;
    const uOverV = alphaU / alphaV;
    const vOverU = alphaV / alphaU;
    const squeezed = halfX * halfX * vOverU + halfY * halfY * uOverV;
    const up = wiZ + woZ;
    const down = wiZ - woZ;
    const up2 = up * up;
    const ratioUp = (halfXy2 + up2) / Math.max(squeezed + alpha2 * up2, 1e-18);
    const down2 = down * down;
    const ratioDown = (halfXy2 + down2) / Math.max(squeezed + alpha2 * down2, 1e-18);
    const below = Math.max(wiZ, 0) + Math.sqrt(alpha2 + (1 - alpha2) * (wiZ * wiZ) + (alphaU -
        alphaV) * (alphaU * (wiX * wiX) - alphaV * (wiY * wiY)));
    return (ratioUp * ratioUp + (down > 0 ? ratioDown * ratioDown : 0)) * (alpha2 /
        6.283185307179586) / below;
}
