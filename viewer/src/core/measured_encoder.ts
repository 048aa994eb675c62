/** Encoding of measured BRDFs; see Python's `material.encode`. */

import { addAlbedos } from "./albedo_rule";
import type { Material } from "./api";
import { joined } from "./channels";
import type { Encoder } from "./encoder";
import type { EnergyLimit } from "./energy";
import { logsOf, nodePairs } from "./f_table";
import { ENCODE, LOBE } from "./formulas";
import { findLobe } from "./interface_fit";
import { lobeValues } from "./lobe";
import { readMeasured, valuesAt } from "./measured/read";
import { probeDirections } from "./probe_pairs";
import { difference, type Refinement } from "./refinement";

const { DIELECTRIC, DIFFUSE_QUANTILE, HELPFUL_REST, NEAR_LOBE } = ENCODE;

export class MeasuredEncoder {
  /** @param nothing the rest that the encoder makes of none. */
  constructor(
    private readonly encoder: Encoder,
    private readonly energy: EnergyLimit,
    private readonly refinement: Refinement,
    private readonly nothing: Float32Array,
  ) {}

  /**
   * The codes and the table of a MERL table or an RGL material, which are isotropic, by networks of
   * one width.
   *
   * @throws FileError if the file is damaged or of another format.
   */
  encode(file: ArrayBuffer): Material {
    const measured = readMeasured(file);
    const { wi, wo } = probeDirections(this.encoder.pairs.capacity, 1);
    const { rule } = this.energy;
    const probed = valuesAt(measured, wi, wo);
    const nodes = valuesAt(measured, rule.wi, rule.wo);
    const codes = probed.map((values, channel) =>
      this.encodeChannel(values, nodes[channel as 0 | 1 | 2]),
    );
    const tabulated = nodePairs();
    const logs = logsOf(valuesAt(measured, tabulated.wi, tabulated.wo));
    return {
      table: { logs, besideLobe: false },
      latents: joined(codes.map(({ code }) => code)),
      anchors: joined(codes.map(({ anchor }) => anchor)),
    };
  }

  private encodeChannel(
    probed: Float64Array,
    nodes: Float64Array,
  ): { code: Float32Array; anchor: Float32Array } {
    const { energy, encoder } = this;
    const lobe = findLobe(encoder.pairs, probed);
    const own = new Float64Array(energy.rule.cosines.length);
    addAlbedos(energy.rule, difference(nodes, lobeValues(lobe, energy.rule.pairs)), own);
    energy.lobeAlbedo.add(lobe, 0, own);
    const ceiling = energy.ceilingOf(own);
    const codes = this.refinement.refine(lobe, probed, nodes);
    energy.limit(codes.code, ceiling);
    energy.limit(codes.anchor, ceiling);
    if (this.isFittedDielectric(codes.anchor, probed)) {
      codes.anchor = encoder.encode(LOBE.NO_LOBE, probed);
    }
    const { alone, relative } = this.refinement.errorsOf(codes.anchor, probed);
    if (alone < NEAR_LOBE) {
      const [low, high] = HELPFUL_REST;
      this.keepRest(codes.anchor, Math.min(Math.max((high - relative) / (high - low), 0), 1));
    }
    return codes;
  }

  /** Whether the lobe of an anchor lies over a bright surface; `with_dielectrics_in_rests`. */
  private isFittedDielectric(anchor: Float32Array, probed: Float64Array): boolean {
    const [normal, grazing, exact] = anchor.subarray(1, 4);
    const rest = difference(probed, lobeValues(anchor, this.encoder.pairs)).sort();
    const place = DIFFUSE_QUANTILE * (rest.length - 1);
    const below = Math.floor(place);
    const diffuse = rest[below] + (place - below) * (rest[below + 1] - rest[below]);
    const seen = normal < DIELECTRIC && exact === 0 && normal + grazing > LOBE.VISIBLE;
    return seen && Math.PI * diffuse > 0.5 * normal;
  }

  /** Blend an anchor with that of its lobe alone; kept: the share of its own rest. */
  private keepRest(anchor: Float32Array, kept: number): void {
    const lobe = anchor.length - this.nothing.length;
    this.nothing.forEach((number, k) => {
      anchor[lobe + k] = kept * anchor[lobe + k] + (1 - kept) * number;
    });
  }
}
