/** Codes of described surfaces without coats and of measured BRDFs; see Python's `material.values`. */

import type { Material } from "./api";
import type { Basis } from "./basis";
import { joined, perChannel } from "./channels";
import type { EnergyLimit } from "./energy";
import { logsOf, nodePairs } from "./f_table";
import { fitLobe } from "./lobe_fit";
import { readMeasured, valuesAt } from "./measured/read";
import { lobeOfSurface, ofChannel, type Surface } from "./surfaces";

export class Encoder {
  /** The latest surface, which stays the same while its coats are changed. */
  private latest: { readonly name: string; readonly codes: Float32Array } | undefined;

  constructor(
    private readonly basis: Basis,
    private readonly energy: EnergyLimit,
  ) {}

  /** The codes (3, L) of a surface. */
  encode(surface: Surface): Float32Array {
    const name = JSON.stringify(surface);
    if (this.latest?.name !== name) {
      this.latest = { name, codes: this.encodeAll(surface) };
    }
    return this.latest.codes.slice();
  }

  private encodeAll(surface: Surface): Float32Array {
    const { widths } = this.basis;
    const reflectance = surface.kind === "diffuse" ? surface.reflectance : 0;
    return perChannel(
      (channel) => [...lobeOfSurface(surface, channel, widths), ofChannel(reflectance, channel)],
      (channel) => this.encodeChannel(surface, channel),
    );
  }

  private encodeChannel(surface: Surface, channel: number): Float32Array {
    const { energy, basis } = this;
    const lobe = lobeOfSurface(surface, channel, basis.widths);
    if (surface.kind !== "diffuse") return basis.without(lobe); // it is its lobe alone
    const value = ofChannel(surface.reflectance, channel) / Math.PI;
    const code = basis.encode(lobe, new Float64Array(basis.probes.capacity).fill(value));
    energy.limit(code, energy.ceilingOf(energy.albedos(energy.pairs.cosD.map(() => value))));
    return code;
  }

  /**
   * The codes and the table of a MERL table or an RGL material, which are isotropic, by a basis of
   * one width.
   *
   * @throws FileError if the file is damaged or of another format.
   */
  encodeMeasured(file: ArrayBuffer): Material {
    const measured = readMeasured(file);
    const { basis, energy } = this;
    const nodes = valuesAt(measured, energy.pairs);
    const codes = valuesAt(measured, basis.probes).map((values, channel) => {
      const code = basis.encode(fitLobe(basis.probes, values), values);
      energy.limit(code, energy.ceilingOf(energy.albedos(nodes[channel as 0 | 1 | 2])));
      return code;
    });
    const logs = logsOf(valuesAt(measured, nodePairs()));
    return { latents: joined(codes), table: { logs, besideLobe: false } };
  }
}
