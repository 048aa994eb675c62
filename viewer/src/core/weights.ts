/** Basis and networks from a weights file of `urushi train`, or from the page's own. */

import { FEATURES, LOBE, PROPOSAL, TABLE } from "../printed/formulas";
import type { BasisWeights } from "./basis";
import { NODES, type Widths } from "./f_table";
import type { ProposalWeights } from "./mixture";
import { Network } from "./network";
import { type Fields, FileError, TensorFile } from "./safetensors";

/** Version of the file format. */
const FORMAT_VERSION = 1;

/** Sizes of codes and networks; see Python's `nets.networks`. */
export interface Architecture {
  /** Numbers of one channel's code. */
  readonly latent: number;
  /** GGX widths of a surface. */
  readonly widths: Widths;
  /** Numbers of a code that describe its lobe. */
  readonly lobe: number;
  /** Numbers of the rest, which follow those of the lobe and begin with a gain. */
  readonly rest: number;
}

/** Sizes and parameters of all. */
export interface Weights {
  readonly arch: Architecture;
  /** Identifies basis and networks: materials belong to them. */
  readonly fingerprint: string;
  readonly basis: BasisWeights;
  readonly layerer: Network;
  readonly proposal: ProposalWeights;
}

/**
 * Read a weights file.
 *
 * @throws FileError if it is damaged, or of networks that this core does not know.
 */
export function readWeights(file: ArrayBuffer): Weights {
  const tensors = new TensorFile(new Uint8Array(file));
  const { description } = tensors;
  if (description.kind !== "weights" || description.version !== FORMAT_VERSION) {
    throw new FileError("The file holds no weights of Urushi's networks in a version known here.");
  }
  const sizes = Object(description.architecture) as Fields;
  const arch = readArchitecture(sizes);
  const { widths, rest } = arch;
  const activation = String(sizes.activation);
  const ofLobe = LOBE.LOBE_FEATURES[widths];
  const ofCoat = FEATURES.COAT_FEATURES[widths];
  return {
    arch,
    fingerprint: String(description.fingerprint ?? ""),
    basis: readBasis(tensors, arch, sizes.azimuthal),
    layerer: new Network(tensors, "layerer", rest + ofLobe + ofCoat, rest, activation),
    proposal: readProposal(tensors, rest),
  };
}

function readArchitecture(sizes: Fields): Architecture {
  const widths = (sizes.widths ?? 1) as Widths;
  const lobe = LOBE.NUMBERS[widths].length;
  // The last number of a code of two widths is the stretch of the basis.
  const rest = Number(sizes.functions) + Number(widths === 2);
  return { latent: lobe + rest, widths, lobe, rest };
}

function readProposal(tensors: TensorFile, rest: number): ProposalWeights {
  const { ALPHAS, TERMS } = PROPOSAL;
  return {
    weight: tensors.numbers("proposal.weight", [rest, TERMS]),
    bias: tensors.numbers("proposal.bias", [TERMS]),
    overlap: tensors.numbers("proposal.overlap", [ALPHAS.length]),
  };
}

function readBasis(
  tensors: TensorFile,
  { widths, rest }: Architecture,
  azimuthal: unknown,
): BasisWeights {
  const count = widths === 1 ? rest : rest - 1;
  const bounds = [1 + count];
  for (const size of Array.isArray(azimuthal) ? azimuthal.map(Number).reverse() : [])
    bounds.unshift(bounds[0] - size);
  const rowsOf = tensors.shapeOf("basis.bytes").length > 0 ? unpackedRows : gridRows;
  return { widths, rows: rowsOf(tensors, count), bounds: [0, ...bounds] };
}

/** The rows (nodes, 1 + K): numbers of sixteen bits, by the lowest values and the steps of columns. */
function gridRows(tensors: TensorFile, count: number): Float32Array {
  const grid = tensors.numbers("basis.grid", [2, 1 + count]);
  const values = tensors.numbers("basis.rows", [NODES, 1 + count]);
  return Float32Array.from(values, (number, at) => {
    const column = at % (1 + count);
    return grid[column] + grid[1 + count + column] * number;
  });
}

/**
 * The rows (nodes, 1 + K) of the page's own file.
 *
 * "basis.bytes" has the low bytes, then the high bytes of numbers (K, nodes): of b, then of the
 * functions without the first, which is one. Half a number, rounded, is the difference from the node
 * before along all axes in turn, in steps of "basis.step"; odd ones are negative.
 */
function unpackedRows(tensors: TensorFile, count: number): Float32Array {
  const nodes = NODES;
  const bytes = tensors.numbers("basis.bytes", [2, count, nodes]);
  const [step] = tensors.numbers("basis.step", [1]);
  const rows = new Float32Array(nodes * (1 + count));
  const steps = new Int32Array(nodes);
  for (let k = 0; k < count; k++) {
    for (let node = 0; node < nodes; node++) {
      const at = k * nodes + node;
      const number = bytes[at] + 256 * bytes[count * nodes + at];
      steps[node] = (number >> 1) ^ -(number & 1);
    }
    let stride = nodes;
    for (const size of TABLE.SHAPE) {
      const whole = stride;
      stride /= size;
      for (let node = 0; node < nodes; node++)
        if (node % whole >= stride) steps[node] += steps[node - stride];
    }
    const column = k === 0 ? 0 : k + 1;
    for (let node = 0; node < nodes; node++) rows[node * (1 + count) + column] = step * steps[node];
  }
  for (let at = 1; at < rows.length; at += 1 + count) rows[at] = 1;
  return rows;
}
