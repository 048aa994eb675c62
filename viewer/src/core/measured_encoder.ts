/** Encoding of measured BRDFs; see Python's `material.values`. */

import { addAlbedos } from "./albedo_rule";
import type { Material } from "./api";
import { type Basis, difference } from "./basis";
import { joined } from "./channels";
import type { EnergyLimit } from "./energy";
import { logsOf, nodePairs } from "./f_table";
import { findLobe } from "./interface_fit";
import { lobeValues } from "./lobe";
import { readMeasured, valuesAt } from "./measured/read";
import { probeDirections } from "./probe_pairs";

export class MeasuredEncoder {
  constructor(
    private readonly basis: Basis,
    private readonly energy: EnergyLimit,
  ) {}

  /**
   * The codes and the table of a MERL table or an RGL material, which are isotropic, by a basis of
   * one width.
   *
   * @throws FileError if the file is damaged or of another format.
   */
  encode(file: ArrayBuffer): Material {
    const measured = readMeasured(file);
    const { wi, wo } = probeDirections(this.basis.probes.capacity, 1);
    const { rule } = this.energy;
    const nodes = valuesAt(measured, rule.wi, rule.wo);
    const codes = valuesAt(measured, wi, wo).map((values, channel) =>
      this.encodeChannel(values, nodes[channel as 0 | 1 | 2]),
    );
    const tabulated = nodePairs();
    const logs = logsOf(valuesAt(measured, tabulated.wi, tabulated.wo));
    return { latents: joined(codes), table: { logs, besideLobe: false } };
  }

  /** The code of values [1/sr] at the probe pairs and the albedo nodes. */
  private encodeChannel(probed: Float64Array, nodes: Float64Array): Float32Array {
    const { energy, basis } = this;
    const lobe = findLobe(basis.probes, probed);
    const own = new Float64Array(energy.rule.cosines.length);
    addAlbedos(energy.rule, difference(nodes, lobeValues(lobe, energy.rule.pairs)), own);
    energy.lobeAlbedo.add(lobe, 0, own);
    const code = basis.encode(lobe, probed);
    energy.limit(code, energy.ceilingOf(own));
    return code;
  }
}
