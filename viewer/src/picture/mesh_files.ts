/** Meshes of files, by the loaders of three.js. The y axis is up, of PLY z. */

import {
  type BufferAttribute,
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  Matrix3,
  Mesh as MeshObject,
  Vector3,
} from "three";
import { GLTFLoader, type GLTFLoaderPlugin } from "three/addons/loaders/GLTFLoader.js";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { PLYLoader } from "three/addons/loaders/PLYLoader.js";
import { mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import { FileError } from "../core/safetensors";
import { joined, type Mesh, type Part, VERTEX_NUMBERS } from "./meshes";

const MOST_TRIANGLES = 1_000_000;

/** Radius of the ball around a mesh that was opened, as that of the page's own objects. */
const RADIUS = 0.7;

/**
 * The mesh of a file, scaled, upright and on the ground.
 *
 * @param suffix "obj", "gltf", "glb" or "ply".
 * @throws FileError if it is damaged, has no triangles or too many, or needs an extension.
 */
export async function readMesh(bytes: Uint8Array<ArrayBuffer>, suffix: string): Promise<Mesh> {
  try {
    return joined([partOf(placed(await READERS[suffix as keyof typeof READERS](bytes)))]);
  } catch (error) {
    throw error instanceof FileError ? error : damaged();
  }
}

/** Readers of objects with z up. */
const READERS = {
  obj: async (bytes: Uint8Array) => upright(readObj(new TextDecoder().decode(bytes))),
  glb: readGltf,
  gltf: readGltf,
  ply: async (bytes: Uint8Array<ArrayBuffer>) => {
    const head = new TextDecoder("latin1").decode(bytes.subarray(0, 4096));
    checkCount(Number(/element face (\d+)/.exec(head)?.[1] ?? 0));
    return new MeshObject(new PLYLoader().parse(bytes.buffer));
  },
};

/** A file of Wavefront; where it has no normals, each of its objects is smooth. */
function readObj(text: string): Group {
  const group = new OBJLoader().parse(text);
  const hasNormals = /^\s*vn\s/m.test(text);
  for (const object of group.children) {
    if (!(object instanceof MeshObject)) continue;
    if (!hasNormals) object.geometry.deleteAttribute("normal");
    object.geometry = mergeVertices(object.geometry);
  }
  return group;
}

/** A file of glTF 2.0, without its materials. */
async function readGltf(bytes: Uint8Array<ArrayBuffer>): Promise<Group> {
  const loader = new GLTFLoader().register(({ json }) => {
    let inside: (ArrayBuffer | undefined)[] = [];
    return {
      name: "bare",
      async beforeRoot() {
        const { accessors = [], buffers = [], meshes = [], extensionsRequired = [] } = json;
        const unknown = extensionsRequired.filter((name: string) => !EXTENSIONS.includes(name));
        if (unknown.length > 0)
          throw new FileError(`It needs ${unknown.join(", ")}; export it without.`);
        inside = buffers.map(({ uri }: { uri?: string }) => uri && bytesOfUri(uri));
        let corners = 0;
        for (const { primitives } of meshes)
          for (const primitive of primitives) {
            const { indices, attributes } = primitive;
            corners += accessors[indices ?? attributes.POSITION].count;
            delete primitive.material;
          }
        checkCount(corners / 3); // before its numbers are read
        Object.assign(json, { animations: [], skins: [] });
      },
      /** The policy of the page permits no request for data inside of the file. */
      loadBufferView(index) {
        const { buffer, byteOffset = 0, byteLength } = json.bufferViews[index];
        const data = inside[buffer]?.slice(byteOffset, byteOffset + byteLength);
        return (data ?? null) && Promise.resolve(data as ArrayBuffer);
      },
    } as GLTFLoaderPlugin & { name: string };
  });
  const { scene } = await loader.parseAsync(bytes.buffer, "");
  return upright(scene);
}

function bytesOfUri(uri: string): ArrayBuffer {
  if (!uri.startsWith("data:"))
    throw new FileError("Its data lie in another file; export it as .glb.");
  return Uint8Array.from(atob(uri.split(",")[1]), (character) => character.charCodeAt(0)).buffer;
}

/** Extensions that the loader reads without further files. */
const EXTENSIONS = ["KHR_mesh_quantization", "KHR_texture_transform"];

function upright(object: MeshObject | Group): Group {
  object.rotation.x = Math.PI / 2;
  return new Group().add(object);
}

function checkCount(triangles: number): void {
  if (triangles > MOST_TRIANGLES)
    throw new FileError("It has more than a million triangles; simplify it.");
}

/** All triangles of an object as one, in the ball of radius `RADIUS`, on the ground. */
function placed(root: MeshObject | Group): BufferGeometry {
  root.updateMatrixWorld();
  const [position, normal, uv, faces]: number[][] = [[], [], [], []];
  const [place, way] = [new Vector3(), new Matrix3()];
  root.traverse((object) => {
    if (!(object instanceof MeshObject)) return;
    const { geometry, matrixWorld } = object as MeshObject;
    if (!geometry.hasAttribute("normal")) geometry.computeVertexNormals();
    const { attributes, index } = geometry;
    const { count } = attributes.position!;
    way.getNormalMatrix(matrixWorld);
    const [before, turn] = [position.length / 3, matrixWorld.determinant() < 0 ? 1 : 0];
    for (let k = 0; k < count; k++) {
      place.fromBufferAttribute(attributes.position!, k).applyMatrix4(matrixWorld);
      position.push(place.x, place.y, place.z);
      place.fromBufferAttribute(attributes.normal!, k).applyNormalMatrix(way);
      normal.push(place.x, place.y, place.z);
      uv.push(attributes.uv?.getX(k) ?? 0, attributes.uv?.getY(k) ?? 0);
    }
    // A mirrored object turns its triangles (glTF 2.0, 3.7.4).
    for (let at = 0; at < (index?.count ?? count); at += 3)
      for (const corner of [at, at + 1 + turn, at + 2 - turn])
        faces.push(before + (index ? index.getX(corner) : corner));
  });
  if (faces.length === 0) throw new FileError("It has no triangles.");
  checkCount(faces.length / 3);
  const last = position.length / 3;
  if (!position.every(Number.isFinite) || !faces.every((k) => k < last)) throw damaged();
  const whole = new BufferGeometry()
    .setAttribute("position", new Float32BufferAttribute(position, 3))
    .setAttribute("normal", new Float32BufferAttribute(normal, 3))
    .setAttribute("uv", new Float32BufferAttribute(uv, 2))
    .setIndex(faces);
  whole.computeBoundingBox();
  const { min, max } = whole.boundingBox!;
  const size = max.distanceTo(min) / 2;
  if (!(size > 0)) throw new FileError("All its points are the same.");
  const scale = RADIUS / size;
  return whole
    .translate(-(min.x + max.x) / 2, -(min.y + max.y) / 2, -min.z)
    .scale(scale, scale, scale);
}

/** Vertices with tangents along growing u; around the axis where a vertex has no uv. */
function partOf(geometry: BufferGeometry): Part {
  geometry.computeTangents();
  const { position, normal, uv, tangent } = geometry.attributes as Record<string, BufferAttribute>;
  const vertices = new Float32Array(VERTEX_NUMBERS * position!.count);
  const tangents = new Float32Array(3 * position!.count);
  const [n, t, p] = [new Vector3(), new Vector3(), new Vector3()];
  for (let k = 0; k < position!.count; k++) {
    n.fromBufferAttribute(normal!, k).normalize();
    const isTangent = (way: Vector3) => way.projectOnPlane(n).length() > 1e-4;
    isTangent(t.fromBufferAttribute(tangent!, k)) ||
      isTangent(t.set(-n.y, n.x, 0)) ||
      isTangent(t.set(1, 0, 0)) ||
      isTangent(t.set(0, 1, 0));
    t.normalize().toArray(tangents, 3 * k);
    p.fromBufferAttribute(position!, k).toArray(vertices, VERTEX_NUMBERS * k);
    n.toArray(vertices, VERTEX_NUMBERS * k + 3);
    vertices.set([uv!.getX(k), uv!.getY(k)], VERTEX_NUMBERS * k + 6);
  }
  return { vertices, tangents, faces: geometry.index!.array };
}

function damaged(): FileError {
  return new FileError("It is damaged or no mesh that the page can read.");
}
