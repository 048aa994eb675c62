/** Encoding of measured BRDFs; see Python's `material.values`. */

import type { Material } from "./api";
import type { Basis } from "./basis";
import { joined } from "./channels";
import type { EnergyLimit } from "./energy";
import { logsOf, nodePairs } from "./f_table";
import { fitLobe } from "./lobe_fit";
import { readMeasured, valuesAt } from "./measured/read";

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
    const { basis, energy } = this;
    const nodes = valuesAt(measured, energy.pairs);
    const codes = valuesAt(measured, basis.probes).map((values, channel) => {
      const lobe = fitLobe(basis.probes, values);
      const code = basis.encode(lobe, values);
      energy.limit(code, energy.ceilingOf(energy.albedos(nodes[channel as 0 | 1 | 2])));
      return code;
    });
    const logs = logsOf(valuesAt(measured, nodePairs()));
    return { latents: joined(codes), table: { logs, besideLobe: false } };
  }
}
