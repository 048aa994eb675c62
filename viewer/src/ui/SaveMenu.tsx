/** What the page writes: pictures, descriptions, and its address. */

import type { Material } from "../core/api";
import { isDocument } from "../engine/files";
import type { LargeSize } from "../engine/large_picture";
import { materialFile } from "../engine/material_file";
import type { PageCore } from "../engine/remote";
import { type Session, session, shownOf } from "../engine/session";
import { textures } from "../engine/textures";
import { stackOf } from "../material/material";
import { Refusal } from "../refusal";
import { basisFile, FORMATS, type Format } from "../save/basis_texture";
import { exrFile } from "../save/exr";
import { materialxText } from "../save/materialx";
import { mitsubaDict, mitsubaXml } from "../save/mitsuba";
import { fileName, pythonText } from "../save/python";
import { sceneFile } from "../save/scene";
import { LANGUAGES, type Language, readTemplate, shaderText } from "../save/shader";
import { toAddress, toJson } from "../state/address";
import { announce, complain, material, state, tell } from "../state/store";

const GROUPS = ["Picture", "Material", "Code", "Share"] as const;

/** A kind of file: its place and its name in the menu, what it is, and what makes it. */
interface Kind {
  group: (typeof GROUPS)[number];
  label: string;
  hint: string;
  save: (name: string) => void | Promise<void>;
}

function presentSession(): Session {
  if (session.value === null) throw new Refusal("The networks are not loaded yet.");
  return session.value;
}

/** The core of the material that is shown, and its codes. */
async function encoded(): Promise<{ core: PageCore; codes: Material }> {
  const stack = stackOf(material.value);
  const table = shownOf(material.value)?.table;
  const core = await presentSession().cores.of(stack);
  const codes = await core.layer(stack);
  if (codes.compensation !== undefined)
    throw new Refusal(
      "The codes of an anisotropic material have no energy compensation; switch it off, or save Python or a Mitsuba BSDF.",
    );
  return { core, codes: { ...codes, table: table ?? codes.table } };
}

/** Angle by which the tangent is turned [degrees]. */
const rotation = () => material.value.rotation ?? 0;

/** The material that is shown, as a file for `urushi.load` or the plugin `neural_brdf`. */
async function presentFile(): Promise<Uint8Array<ArrayBuffer>> {
  const { bottom } = material.value;
  if (bottom.kind !== "texels") {
    const { core, codes } = await encoded();
    return materialFile(codes, core, rotation());
  }
  const opened = textures.value.get(bottom.texture);
  if (opened === undefined) throw new Refusal("The texture was not opened.");
  return opened.texture.file;
}

const KINDS: readonly Kind[] = [
  {
    group: "Picture",
    label: "Picture",
    hint: "PNG, as it is seen",
    save: async (name) => {
      download(`${name}.png`, await presentSession().picture());
      tellOfRefining();
    },
  },
  {
    group: "Picture",
    label: "Radiance",
    hint: "EXR, the picture in linear light",
    save: async (name) => {
      download(`${name}.exr`, new Blob([exrFile(await presentSession().radiance())]));
      tellOfRefining();
    },
  },
  {
    group: "Material",
    label: "Material",
    hint: "safetensors, for urushi.load",
    save: async (name) => download(`${name}.safetensors`, new Blob([await presentFile()])),
  },
  {
    group: "Material",
    label: "Mitsuba XML",
    hint: "a BSDF for a scene file",
    save: (name) => download(`${name}.xml`, textBlob(mitsubaXml(material.value))),
  },
  {
    group: "Material",
    label: "Mitsuba dictionary",
    hint: "the same for mi.load_dict",
    save: (name) => download(`${name}-dict.py`, textBlob(mitsubaDict(material.value))),
  },
  {
    group: "Share",
    label: "Mitsuba scene",
    hint: "ZIP: object, camera, light and material",
    save: async (name) => {
      const scene = { ...(await presentSession().scene()), material: await presentFile() };
      download(`${name}-scene.zip`, new Blob([sceneFile(scene)]));
    },
  },
  {
    group: "Code",
    label: "Python",
    hint: "a program with urushi",
    save: (name) => download(`${name}.py`, textBlob(pythonText(material.value))),
  },
  {
    group: "Code",
    label: "MaterialX",
    hint: "an open_pbr_surface, without what that lacks",
    save: (name) => {
      const { text, lost } = materialxText(material.value);
      download(`${name}.mtlx`, textBlob(text));
      if (lost) tell(lost);
    },
  },
  {
    group: "Share",
    label: "State",
    hint: "JSON, to open here again",
    save: (name) => download(`${name}.json`, textBlob(toJson(state.value, 2))),
  },
];

/** Tell that a picture was saved before it was finished. */
function tellOfRefining(): void {
  const { converged, gathered } = presentSession().painter;
  if (converged.value) return;
  const share = Math.round(100 * gathered.value);
  tell(
    `The picture was saved while refining, with ${share} % of its frames; wait until it has converged, or save 2 × or 4K, which are drawn to the end.`,
  );
}

/** The sizes of larger pictures, in words. */
const SIZES: Record<LargeSize, string> = { "2x": "2 ×", "4K": "4K" };

async function saveLarge(size: LargeSize, name: string): Promise<void> {
  download(`${name}-${size}.png`, await presentSession().largePicture(size));
}

const ADDRESS: Kind = {
  group: "Share",
  label: "Copy the address",
  hint: "it holds the whole state",
  save: async () => {
    const address = new URL(`#${toAddress(state.value)}`, location.href).href;
    try {
      await navigator.clipboard.writeText(address);
    } catch {
      throw new Refusal(
        "The browser gives the page no clipboard; copy the address from the address bar.",
      );
    }
    announce("The address was copied.");
  },
};

const LANGUAGE_NAMES = Object.keys(LANGUAGES) as Language[];

async function saveShader(language: Language, name: string): Promise<void> {
  const { core, codes } = await encoded();
  const text = shaderText(await readTemplate(language, core.widths), codes, rotation());
  download(`${name}${LANGUAGES[language].suffix}`, textBlob(text));
  if (!codes.table.isOfCodes)
    tell(
      "The shader code has the codes of the material; for its table, save the material and run urushi export.",
    );
}

async function saveBasis(format: Format): Promise<void> {
  const { core } = await encoded();
  const texels = await core.basisTexels();
  download(`urushi-basis.${format}`, basisFile(texels, format));
}

/** Offer a file for download. */
function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function textBlob(text: string): Blob {
  return new Blob([text], { type: "text/plain" });
}

export function SaveMenu({ onDone }: { onDone: () => void }) {
  const run = async (save: Kind["save"]) => {
    onDone();
    try {
      await save(fileName(material.value.name));
    } catch (error) {
      complain(error, () => void run(save));
    }
  };
  const kinds = isDocument() ? KINDS : [...KINDS, ADDRESS];
  return GROUPS.map((group) => (
    <section key={group}>
      <h2>{group}</h2>
      <ul>
        {kinds
          .filter((kind) => kind.group === group)
          .map(({ label, hint, save }) => (
            <li key={label}>
              <button type="button" onClick={() => void run(save)}>
                <span>{label}</span>
                <small>{hint}</small>
              </button>
            </li>
          ))}
        {group === "Picture" && (
          <li class="languages">
            <small>Larger, drawn to the end</small>
            <div role="group" aria-label="Larger picture">
              {Object.entries(SIZES).map(([size, label]) => (
                <button
                  key={size}
                  type="button"
                  onClick={() => void run((name) => saveLarge(size as LargeSize, name))}
                >
                  {label}
                </button>
              ))}
            </div>
          </li>
        )}
        {group === "Code" && (
          <li class="languages">
            <small>Shaders of f, pdf and sample</small>
            <div role="group" aria-label="Shader code">
              {LANGUAGE_NAMES.map((language) => (
                <button
                  key={language}
                  type="button"
                  onClick={() => void run((name) => saveShader(language, name))}
                >
                  {LANGUAGES[language].title}
                </button>
              ))}
            </div>
            <small>The texture that their f reads: GPU, NumPy, OSL</small>
            <div role="group" aria-label="Texture of the basis">
              {(Object.keys(FORMATS) as Format[]).map((format) => (
                <button
                  key={format}
                  type="button"
                  onClick={() => void run(() => saveBasis(format))}
                >
                  {FORMATS[format]}
                </button>
              ))}
            </div>
          </li>
        )}
      </ul>
    </section>
  ));
}
