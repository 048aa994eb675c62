/** Meshes of files: OBJ, and glTF 2.0 as .glb or with its data inside the .gltf. y is up in them. */

import { FileError } from "../core/safetensors";
import { type Mesh, meshOfPart, type Part, VERTEX_NUMBERS } from "./meshes";

/** Triangles of a file, as it stores them: three numbers a position and a normal, two a uv. */
interface Triangles {
  positions: number[];
  /** Empty where the file has none. */
  normals: number[];
  uvs: number[];
  faces: number[];
}

/** Told the share of a file that has been read. */
type Told = (share: number) => void;

const MOST_TRIANGLES = 1_000_000;

/** Radius of the ball around a mesh that was opened, as that of the page's own objects. */
const RADIUS = 0.7;

/**
 * The mesh of a file, scaled, upright and on the ground.
 *
 * @param suffix "obj", "gltf" or "glb".
 * @throws FileError if it is damaged, has no triangles or too many, or needs an extension.
 */
export function readMesh(bytes: Uint8Array, suffix: string, told: Told = () => {}): Mesh {
  const triangles = suffix === "obj" ? readObj(bytes, told) : readGltf(bytes);
  const { positions, faces } = triangles;
  if (faces.length === 0) throw new FileError("It has no triangles.");
  const last = positions.length / 3;
  if (!positions.every(Number.isFinite) || !faces.every((vertex) => vertex < last)) throw damaged();
  return meshOfPart(partOf(triangles));
}

function checkCount(triangles: number): void {
  if (triangles > MOST_TRIANGLES)
    throw new FileError("It has more than a million triangles; simplify it.");
}

/** The triangles with z up, on the ground, about the axis, with normals and tangents. */
function partOf({ positions, normals, uvs, faces }: Triangles): Part {
  const count = positions.length / 3;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < positions.length; at++) {
    low[at % 3] = Math.min(low[at % 3], positions[at]);
    high[at % 3] = Math.max(high[at % 3], positions[at]);
  }
  const size = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2;
  if (!(size > 0)) throw new FileError("All its points are the same.");
  const scale = RADIUS / size;
  const [x, z] = [0.5 * (low[0] + high[0]), 0.5 * (low[2] + high[2])];
  const own = normals.length === positions.length ? normals : smoothNormals(positions, faces);
  const vertices = new Float32Array(VERTEX_NUMBERS * count);
  for (let vertex = 0; vertex < count; vertex++) {
    const [from, to] = [3 * vertex, VERTEX_NUMBERS * vertex];
    vertices[to] = (positions[from] - x) * scale;
    vertices[to + 1] = (z - positions[from + 2]) * scale;
    vertices[to + 2] = (positions[from + 1] - low[1]) * scale;
    const length = Math.hypot(own[from], own[from + 1], own[from + 2]) || 1;
    vertices[to + 3] = own[from] / length;
    vertices[to + 4] = -own[from + 2] / length;
    vertices[to + 5] = own[from + 1] / length;
    vertices[to + 6] = uvs[2 * vertex] ?? 0;
    vertices[to + 7] = uvs[2 * vertex + 1] ?? 0;
  }
  return { vertices, tangents: tangentsOf(vertices, faces), faces };
}

/** Sums of the normals of the faces at each vertex, by their areas. */
function smoothNormals(positions: ArrayLike<number>, faces: readonly number[]): Float32Array {
  const normals = new Float32Array(positions.length);
  for (let at = 0; at < faces.length; at += 3) {
    const [a, b, c] = [3 * faces[at], 3 * faces[at + 1], 3 * faces[at + 2]];
    for (let k = 0; k < 3; k++) {
      const [i, j] = [(k + 1) % 3, (k + 2) % 3];
      const area =
        (positions[b + i] - positions[a + i]) * (positions[c + j] - positions[a + j]) -
        (positions[b + j] - positions[a + j]) * (positions[c + i] - positions[a + i]);
      normals[a + k] += area;
      normals[b + k] += area;
      normals[c + k] += area;
    }
  }
  return normals;
}

/** Unit tangents along growing u; around the axis where a vertex has no uv. */
function tangentsOf(vertices: Float32Array, faces: readonly number[]): Float32Array {
  const count = vertices.length / VERTEX_NUMBERS;
  const sums = new Float32Array(3 * count);
  for (let at = 0; at < faces.length; at += 3) {
    const corners = [faces[at], faces[at + 1], faces[at + 2]] as const;
    const [a, b, c] = [0, 1, 2].map((corner) => corners[corner] * VERTEX_NUMBERS);
    const [bu, bv] = [vertices[b + 6] - vertices[a + 6], vertices[b + 7] - vertices[a + 7]];
    const [cu, cv] = [vertices[c + 6] - vertices[a + 6], vertices[c + 7] - vertices[a + 7]];
    const sign = Math.sign(bu * cv - cu * bv);
    if (sign === 0) continue;
    for (let k = 0; k < 3; k++) {
      const [along, across] = [
        vertices[b + k] - vertices[a + k],
        vertices[c + k] - vertices[a + k],
      ];
      for (const corner of corners) sums[3 * corner + k] += sign * (cv * along - bv * across);
    }
  }
  const flat = [0, 0, 0];
  /** Whether the part of a vector in the surface of a vertex, which becomes its tangent, is not 0. */
  const isTangent = (vertex: number, x: number, y: number, z: number): boolean => {
    const at = vertex * VERTEX_NUMBERS + 3;
    const along = x * vertices[at] + y * vertices[at + 1] + z * vertices[at + 2];
    flat[0] = x - along * vertices[at];
    flat[1] = y - along * vertices[at + 1];
    flat[2] = z - along * vertices[at + 2];
    const length = Math.hypot(flat[0], flat[1], flat[2]);
    if (length <= 1e-4 * Math.hypot(x, y, z)) return false;
    for (let k = 0; k < 3; k++) sums[3 * vertex + k] = flat[k] / length;
    return true;
  };
  for (let vertex = 0; vertex < count; vertex++) {
    const [at, to] = [vertex * VERTEX_NUMBERS, 3 * vertex];
    isTangent(vertex, sums[to], sums[to + 1], sums[to + 2]) ||
      isTangent(vertex, -vertices[at + 1], vertices[at], 0) ||
      isTangent(vertex, 1, 0, 0) ||
      isTangent(vertex, 0, 1, 0);
  }
  return sums;
}

/** Bytes of text that are decoded at a time. */
const CHUNK = 1 << 20;

/** A file of Wavefront; faces with more corners become fans. */
function readObj(bytes: Uint8Array, told: Told): Triangles {
  const lists = { v: [] as number[], vt: [] as number[], vn: [] as number[] };
  const found: Triangles = { positions: [], normals: [], uvs: [], faces: [] };
  const known = new Map<string, number>();
  /** The place in a list of numbers of `width` that a word of a corner names; below 0: of none. */
  const placeOf = (word: string | undefined, list: number[], width: number): number => {
    const number = Number(word || Number.NaN);
    const place = width * (number > 0 ? number - 1 : list.length / width + number);
    return place < list.length ? place : -1;
  };
  const vertex = (word: string): number => {
    const before = known.get(word);
    if (before !== undefined) return before;
    const words = word.split("/");
    const v = placeOf(words[0], lists.v, 3);
    if (!(v >= 0)) throw damaged();
    found.positions.push(lists.v[v], lists.v[v + 1], lists.v[v + 2]);
    const [vt, vn] = [placeOf(words[1], lists.vt, 2), placeOf(words[2], lists.vn, 3)];
    found.uvs.push(lists.vt[vt] ?? 0, lists.vt[vt + 1] ?? 0);
    if (vn >= 0) found.normals.push(lists.vn[vn], lists.vn[vn + 1], lists.vn[vn + 2]);
    known.set(word, known.size);
    return known.size - 1;
  };
  const readLine = (line: string): void => {
    const [kind, ...words] = line.trim().split(/\s+/);
    if (kind === "v" || kind === "vn")
      lists[kind].push(Number(words[0]), Number(words[1]), Number(words[2]));
    else if (kind === "vt") lists.vt.push(Number(words[0]), Number(words[1] ?? 0));
    if (kind !== "f") return;
    const corners = words.map(vertex);
    for (let k = 2; k < corners.length; k++)
      found.faces.push(corners[0], corners[k - 1], corners[k]);
    checkCount(found.faces.length / 3);
  };
  const decoder = new TextDecoder();
  let rest = "";
  for (let at = 0; at < bytes.length; at += CHUNK) {
    const lines = (rest + decoder.decode(bytes.subarray(at, at + CHUNK), { stream: true })).split(
      "\n",
    );
    rest = lines.pop() ?? "";
    lines.forEach(readLine);
    told(at / bytes.length);
  }
  readLine(rest);
  return found;
}

type Json = Record<string, unknown>;

/** Arrays of the types of components (glTF 2.0, 3.6.2.2). */
const COMPONENTS: Record<number, [size: number, read: "Uint8" | "Uint16" | "Uint32" | "Float32"]> =
  {
    5121: [1, "Uint8"],
    5123: [2, "Uint16"],
    5125: [4, "Uint32"],
    5126: [4, "Float32"],
  };
const WIDTHS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3 };
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** A file of glTF 2.0 (Khronos Group 2021): the triangles of its scene. */
function readGltf(bytes: Uint8Array): Triangles {
  const { json, binary } = gltfParts(bytes);
  const list = (name: string) => (json[name] ?? []) as Json[];
  if (list("extensionsRequired").length > 0)
    throw new FileError(`It needs ${list("extensionsRequired").join(", ")}; export it without.`);
  const buffers = list("buffers").map(({ uri }) => {
    if (uri === undefined) return binary;
    const [head, data] = String(uri).split(",");
    if (!head!.startsWith("data:") || data === undefined)
      throw new FileError("Its data lie in another file; export it as .glb.");
    return Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  });
  const numbers = (place: unknown): number[] => {
    const accessor = list("accessors")[place as number]!;
    const {
      bufferView,
      byteOffset = 0,
      componentType,
      count,
      type,
    } = accessor as Record<string, number>;
    const view = list("bufferViews")[bufferView!] as Record<string, number>;
    const [size, read] = COMPONENTS[componentType!]!;
    const width = WIDTHS[String(type)]!;
    const buffer = buffers[view.buffer!]!;
    const data = new DataView(buffer.buffer, buffer.byteOffset, buffer.byteLength);
    const start = (view.byteOffset ?? 0) + byteOffset;
    const stride = view.byteStride ?? width * size;
    const scale = accessor.normalized ? 1 / (256 ** size - 1) : 1;
    return Array.from({ length: count! * width }, (_, at) => {
      const from = start + Math.floor(at / width) * stride + (at % width) * size;
      return data[`get${read}`](from, true) * scale;
    });
  };
  const found: Triangles = { positions: [], normals: [], uvs: [], faces: [] };
  const visit = (place: number, above: readonly number[], depth: number): void => {
    const node = list("nodes")[place]!;
    const matrix = product(above, matrixOf(node));
    const mesh = list("meshes")[node.mesh as number];
    for (const { mode = 4, attributes, indices } of (mesh?.primitives ?? []) as Json[]) {
      const { POSITION, NORMAL, TEXCOORD_0 } = attributes as Record<string, number>;
      if (mode !== 4 || POSITION === undefined) continue;
      const count = list("accessors")[(indices ?? POSITION) as number]!.count as number;
      checkCount((found.faces.length + count) / 3); // before its numbers are read
      const before = found.positions.length / 3;
      const positions = numbers(POSITION);
      const order = indices === undefined ? [...Array(count).keys()] : numbers(indices);
      const normals = NORMAL === undefined ? smoothNormals(positions, order) : numbers(NORMAL);
      const uvs = TEXCOORD_0 === undefined ? [] : numbers(TEXCOORD_0);
      for (let k = 0; k < (2 * positions.length) / 3; k++) found.uvs.push(uvs[k] ?? 0);
      // A mirrored node turns its triangles (glTF 2.0, 3.7.4).
      const turn = determinant(matrix) < 0 ? 1 : 0;
      const outward = cofactors(matrix).map((x) => (turn === 1 ? -x : x));
      for (let at = 0; at < positions.length; at += 3)
        for (let row = 0; row < 3; row++) {
          found.positions.push(movedPart(matrix, positions, at, row) + matrix[12 + row]!);
          found.normals.push(movedPart(outward, normals, at, row));
        }
      for (let at = 0; at < order.length; at += 3)
        for (const corner of [0, 1 + turn, 2 - turn])
          found.faces.push(before + order[at + corner]!);
    }
    if (depth < 64)
      for (const child of (node.children ?? []) as number[]) visit(child, matrix, depth + 1);
  };
  try {
    const scene = list("scenes")[(json.scene as number) ?? 0];
    for (const root of (scene?.nodes ?? []) as number[]) visit(root, IDENTITY, 0);
  } catch (error) {
    throw error instanceof FileError ? error : damaged();
  }
  return found;
}

/** The text and the binary part of a .glb or of a .gltf. */
function gltfParts(bytes: Uint8Array): { json: Json; binary: Uint8Array } {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  try {
    if (view.getUint32(0, true) !== 0x46546c67)
      return { json: JSON.parse(new TextDecoder().decode(bytes)), binary: new Uint8Array() };
    const end = 20 + view.getUint32(12, true);
    const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, end)));
    return { json, binary: bytes.subarray(end + 8) };
  } catch {
    throw damaged();
  }
}

/** A node's matrix, column by column. */
function matrixOf(node: Json): number[] {
  if (node.matrix !== undefined) return node.matrix as number[];
  const [x, y, z, w] = (node.rotation ?? [0, 0, 0, 1]) as [number, number, number, number];
  const [a, b, c] = (node.scale ?? [1, 1, 1]) as [number, number, number];
  const [u, v, t] = (node.translation ?? [0, 0, 0]) as [number, number, number];
  return [
    ...[1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)].map((e) => a * e),
    0,
    ...[2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)].map((e) => b * e),
    0,
    ...[2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)].map((e) => c * e),
    0,
    ...[u, v, t, 1],
  ];
}

function product(a: readonly number[], b: readonly number[]): number[] {
  return a.map((_, at) => {
    const [row, column] = [at % 4, at - (at % 4)];
    return [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + row]! * b[column + k]!, 0);
  });
}

/** A component of the direction at a place by a matrix. */
function movedPart(m: readonly number[], all: ArrayLike<number>, at: number, row: number): number {
  return m[row] * all[at] + m[4 + row] * all[at + 1] + m[8 + row] * all[at + 2];
}

/** The matrix by which normals move: the cofactors of a matrix's directions. */
function cofactors(m: readonly number[]): number[] {
  const at = (row: number, column: number) => m[4 * (column % 3) + (row % 3)]!;
  return m.map((_, place) => {
    const [row, column] = [place % 4, Math.floor(place / 4)];
    if (row > 2 || column > 2) return 0;
    return (
      at(row + 1, column + 1) * at(row + 2, column + 2) -
      at(row + 1, column + 2) * at(row + 2, column + 1)
    );
  });
}

function determinant(m: readonly number[]): number {
  const minors = cofactors(m);
  return m[0]! * minors[0]! + m[4]! * minors[4]! + m[8]! * minors[8]!;
}

function damaged(): FileError {
  return new FileError("It is damaged or no mesh that the page can read.");
}
