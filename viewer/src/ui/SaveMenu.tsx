/** What the page writes: pictures, descriptions, and its address. */

import type { Material } from "../core/api";
import { isDocument } from "../engine/files";
import type { LargeSize } from "../engine/large_picture";
import { materialFile } from "../engine/material_file";
import { textures } from "../engine/opened";
import { type Session, session, shownOf } from "../engine/session";
import { stackOf } from "../material/material";
import { Refusal } from "../refusal";
import { basisFile, FORMATS, type Format } from "../save/basis_texture";
import { exrFile } from "../save/exr";
import { materialxText } from "../save/materialx";
import { mitsubaXml } from "../save/mitsuba";
import { fileName, pythonText } from "../save/python";
import { sceneFile } from "../save/scene";
import { LANGUAGES, type Language, readTemplate, shaderText } from "../save/shader";
import { toAddress, toJson } from "../state/address";
import { announce, complain, material, state, tell } from "../state/store";
import { Button } from "./Button";

/** A kind of file: its name in the menu, what it is, and what makes it. */
interface Kind {
  label: string;
  hint: string;
  save: (name: string) => void | Promise<void>;
}

function presentSession(): Session {
  if (session.value === null) throw new Refusal("The networks are not loaded yet.");
  return session.value;
}

/** The core of the material that is shown, and its codes. */
async function encoded() {
  const stack = stackOf(material.value);
  const table = shownOf(material.value)?.table;
  const { core, material: codes } = await presentSession().cores.material({ stack, table });
  return { core, codes };
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
  const opened = textures.get(bottom.texture);
  if (opened === undefined) throw new Refusal("The texture was not opened.");
  return opened.texture.file;
}

/** What most people want. */
const FIRST: readonly Kind[] = [
  {
    label: "Picture",
    hint: "PNG, as it is seen",
    save: async (name) => {
      download(`${name}.png`, await presentSession().picture());
      tellOfRefining();
    },
  },
  {
    label: "Copy the address",
    hint: "to share: it holds the whole state",
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
  },
  {
    label: "Material",
    hint: "safetensors, for urushi.load",
    save: async (name) => download(`${name}.safetensors`, await presentFile()),
  },
];

const larger = (size: LargeSize, label: string): Kind => ({
  label,
  hint: "PNG of a larger picture, drawn to the end",
  save: async (name) => download(`${name}-${size}.png`, await presentSession().largePicture(size)),
});

/** All else, by headings. */
const MORE: Readonly<Record<string, readonly Kind[]>> = {
  "Larger pictures and linear light": [
    larger("2x", "2 ×"),
    larger("4K", "4K"),
    {
      label: "Radiance",
      hint: "EXR, the picture in linear light",
      save: async (name) => {
        download(`${name}.exr`, exrFile(await presentSession().radiance()));
        tellOfRefining();
      },
    },
  ],
  "Scenes and descriptions": [
    {
      label: "Mitsuba scene",
      hint: "ZIP: object, camera, light and material",
      save: async (name) => {
        const scene = { ...(await presentSession().scene()), material: await presentFile() };
        download(`${name}-scene.zip`, sceneFile(scene));
      },
    },
    {
      label: "Mitsuba XML",
      hint: "a BSDF for a scene file",
      save: (name) => download(`${name}.xml`, mitsubaXml(material.value)),
    },
    {
      label: "Python",
      hint: "a program with urushi",
      save: (name) => download(`${name}.py`, pythonText(material.value)),
    },
    {
      label: "MaterialX",
      hint: "an open_pbr_surface, without what that lacks",
      save: (name) => {
        const { text, lost } = materialxText(material.value);
        download(`${name}.mtlx`, text);
        if (lost) tell(lost);
      },
    },
    {
      label: "State",
      hint: "JSON, to open here again",
      save: (name) => download(`${name}.json`, toJson(state.value, 2)),
    },
  ],
  "Shaders of f, pdf and sample": (Object.keys(LANGUAGES) as Language[]).map((language) => ({
    label: LANGUAGES[language].title,
    hint: `${LANGUAGES[language].title} code`,
    save: (name) => saveShader(language, name),
  })),
  "The texture that they read": (Object.keys(FORMATS) as Format[]).map((format) => ({
    label: FORMATS[format],
    hint: "the functions of the basis, the same for all materials",
    save: async () => {
      const { core } = await encoded();
      download(`urushi-basis.${format}`, basisFile(await core.basisTexels(), format));
    },
  })),
};

/** Tell that a picture was saved before it was finished. */
function tellOfRefining(): void {
  const { converged, gathered } = presentSession().painter;
  if (converged.value) return;
  const share = Math.round(100 * gathered.value);
  tell(
    `The picture was saved while refining, with ${share} % of its frames; wait until it has converged, or save 2 × or 4K, which are drawn to the end.`,
  );
}

async function saveShader(language: Language, name: string): Promise<void> {
  const { core, codes } = await encoded();
  const text = shaderText(await readTemplate(language, core.widths), codes, rotation());
  download(`${name}${LANGUAGES[language].suffix}`, text);
  if (!codes.table.isOfCodes)
    tell(
      "The shader code has the codes of the material; for its table, save the material and run urushi export.",
    );
  else if (!isStretchedAlike(codes))
    tell(
      "Shader code stretches all channels alike: under this pigment of two widths, f can differ from the page's by 10 % and more.",
    );
}

/** Whether channels of two widths have about the same stretch. */
function isStretchedAlike({ table: { stretches = [0] } }: Material): boolean {
  return Math.max(...stretches) - Math.min(...stretches) < 0.05;
}

/** Offer a file for download. */
function download(name: string, content: BlobPart): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Write a kind of file; what goes wrong is told. */
async function save(kind: Kind): Promise<void> {
  try {
    await kind.save(fileName(material.value.name));
  } catch (error) {
    complain(error, () => void save(kind));
  }
}

export function SaveMenu({ onDone }: { onDone: () => void }) {
  const buttons = (kinds: readonly Kind[]) =>
    kinds.map((kind) => (
      <li key={kind.label}>
        <Button
          title={kind.hint}
          onClick={() => {
            onDone();
            void save(kind);
          }}
        >
          <span>{kind.label}</span>
          <small>{kind.hint}</small>
        </Button>
      </li>
    ));
  return (
    <>
      <ul>
        {buttons(isDocument() ? FIRST.filter((kind) => !kind.hint.includes("share")) : FIRST)}
      </ul>
      {Object.entries(MORE).map(([title, kinds]) => (
        <section key={title}>
          <h2>{title}</h2>
          <ul class="compact">{buttons(kinds)}</ul>
        </section>
      ))}
    </>
  );
}
