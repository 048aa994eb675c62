/** Meshes of files: OBJ, and glTF 2.0 as .glb or with its data inside the .gltf. y is up in them. */

import { Refusal } from "../refusal";
import { type Mesh, meshOfPart, type Part, VERTEX_NUMBERS } from "./meshes";

/** Triangles of a file, as it stores them: three numbers a position and a normal, two a uv. */
interface Triangles {
  positions: number[];
  /** Empty where the file has none. */
  normals: number[];
  uvs: number[];
  faces: number[];
}

const MOST_TRIANGLES = 1_000_000;

/** Radius of the ball around a mesh that was opened, as that of the page's own objects. */
const RADIUS = 0.7;

/**
 * The mesh of a file, scaled, upright and on the ground.
 *
 * @param suffix "obj", "gltf" or "glb".
 * @throws Refusal if it is damaged, has no triangles or too many, or needs an extension.
 */
export function readMesh(bytes: Uint8Array, suffix: string): Mesh {
  const triangles = suffix === "obj" ? readObj(new TextDecoder().decode(bytes)) : readGltf(bytes);
  const { positions, faces } = triangles;
  if (faces.length === 0) throw new Refusal("It has no triangles.");
  if (faces.length > 3 * MOST_TRIANGLES)
    throw new Refusal("It has more than a million triangles; simplify it.");
  const last = positions.length / 3;
  if (!positions.every(Number.isFinite) || !faces.every((vertex) => vertex < last)) throw damaged();
  return meshOfPart(partOf(triangles));
}

/** The triangles with z up, on the ground, about the axis, with normals and tangents. */
function partOf({ positions, normals, uvs, faces }: Triangles): Part {
  const count = positions.length / 3;
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < positions.length; at++) {
    low[at % 3] = Math.min(low[at % 3]!, positions[at]!);
    high[at % 3] = Math.max(high[at % 3]!, positions[at]!);
  }
  const size = Math.hypot(...high.map((x, k) => x - low[k]!)) / 2;
  if (!(size > 0)) throw new Refusal("All its points are the same.");
  const scale = RADIUS / size;
  const [x, z] = [0.5 * (low[0] + high[0]), 0.5 * (low[2] + high[2])];
  const own = normals.length === positions.length ? normals : smoothNormals(positions, faces);
  const part: Part = { vertices: [], tangents: [], faces };
  for (let vertex = 0; vertex < count; vertex++) {
    const at = 3 * vertex;
    const place = [positions[at]! - x, z - positions[at + 2]!, positions[at + 1]! - low[1]];
    const normal = [own[at]!, -own[at + 2]!, own[at + 1]!];
    const length = Math.hypot(...normal) || 1;
    part.vertices.push(place[0]! * scale, place[1]! * scale, place[2]! * scale);
    part.vertices.push(...normal.map((part) => part / length));
    part.vertices.push(uvs[2 * vertex] ?? 0, uvs[2 * vertex + 1] ?? 0);
  }
  part.tangents = tangentsOf(part.vertices, faces);
  return part;
}

/** Sums of the normals of the faces at each vertex, by their areas. */
function smoothNormals(positions: number[], faces: number[]): number[] {
  const normals = new Array<number>(positions.length).fill(0);
  for (let at = 0; at < faces.length; at += 3) {
    const corners = [faces[at]!, faces[at + 1]!, faces[at + 2]!];
    const [a, b, c] = corners.map((corner) => positions.slice(3 * corner, 3 * corner + 3));
    const u = b!.map((value, k) => value - a![k]!);
    const v = c!.map((value, k) => value - a![k]!);
    for (const corner of corners)
      for (let k = 0; k < 3; k++) {
        const [i, j] = [(k + 1) % 3, (k + 2) % 3];
        normals[3 * corner + k]! += u[i]! * v[j]! - u[j]! * v[i]!;
      }
  }
  return normals;
}

/** Unit tangents along growing u; around the axis where a vertex has no uv. */
function tangentsOf(vertices: number[], faces: number[]): number[] {
  const count = vertices.length / VERTEX_NUMBERS;
  const sums = new Array<number>(3 * count).fill(0);
  for (let at = 0; at < faces.length; at += 3) {
    const corners = [faces[at]!, faces[at + 1]!, faces[at + 2]!];
    const [a, b, c] = corners.map((corner) => corner * VERTEX_NUMBERS);
    const of = (to: number, k: number) => vertices[to + k]! - vertices[a! + k]!;
    const [bu, bv, cu, cv] = [of(b!, 6), of(b!, 7), of(c!, 6), of(c!, 7)];
    const sign = Math.sign(bu * cv - cu * bv);
    for (const corner of corners)
      for (let k = 0; k < 3; k++) sums[3 * corner + k]! += sign * (cv * of(b!, k) - bv * of(c!, k));
  }
  for (let vertex = 0; vertex < count; vertex++) {
    const at = vertex * VERTEX_NUMBERS;
    const normal = vertices.slice(at + 3, at + 6);
    const candidates = [
      sums.slice(3 * vertex, 3 * vertex + 3),
      [-vertices[at + 1]!, vertices[at]!, 0],
      [1, 0, 0],
      [0, 1, 0],
    ];
    for (const candidate of candidates) {
      const along = candidate.reduce((sum, part, k) => sum + part * normal[k]!, 0);
      const flat = candidate.map((part, k) => part - along * normal[k]!);
      const length = Math.hypot(...flat);
      if (length <= 1e-4 * Math.hypot(...candidate)) continue;
      for (let k = 0; k < 3; k++) sums[3 * vertex + k] = flat[k]! / length;
      break;
    }
  }
  return sums;
}

/** A file of Wavefront; faces with more corners become fans. */
function readObj(text: string): Triangles {
  const lists: Record<string, number[][]> = { v: [], vt: [], vn: [] };
  const found: Triangles = { positions: [], normals: [], uvs: [], faces: [] };
  const known = new Map<string, number>();
  const vertex = (word: string): number => {
    const before = known.get(word);
    if (before !== undefined) return before;
    const [v, vt, vn] = ["v", "vt", "vn"].map((name, k) => {
      const number = Number(word.split("/")[k] || Number.NaN);
      return lists[name]!.at(number > 0 ? number - 1 : number);
    });
    if (v === undefined || v.length < 3) throw damaged();
    found.positions.push(...v.slice(0, 3));
    found.uvs.push(vt?.[0] ?? 0, vt?.[1] ?? 0);
    if (word.split("/")[2]) found.normals.push(...(vn ?? []).slice(0, 3));
    known.set(word, known.size);
    return known.size - 1;
  };
  for (const line of text.split(/\r?\n/)) {
    const [kind = "", ...words] = line.trim().split(/\s+/);
    if (kind in lists) lists[kind]!.push(words.map(Number));
    if (kind !== "f") continue;
    const corners = words.map(vertex);
    for (let k = 2; k < corners.length; k++)
      found.faces.push(corners[0]!, corners[k - 1]!, corners[k]!);
  }
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
    throw new Refusal(`It needs ${list("extensionsRequired").join(", ")}; export it without.`);
  const buffers = list("buffers").map(({ uri }) => {
    if (uri === undefined) return binary;
    const [head, data] = String(uri).split(",");
    if (!head!.startsWith("data:") || data === undefined)
      throw new Refusal("Its data lie in another file; export it as .glb.");
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
      const before = found.positions.length / 3;
      const positions = numbers(POSITION);
      const order =
        indices === undefined ? [...Array(positions.length / 3).keys()] : numbers(indices);
      const normals = NORMAL === undefined ? smoothNormals(positions, order) : numbers(NORMAL);
      for (const x of TEXCOORD_0 === undefined
        ? new Array((positions.length / 3) * 2).fill(0)
        : numbers(TEXCOORD_0))
        found.uvs.push(x);
      // A mirrored node turns its triangles (glTF 2.0, 3.7.4).
      const turn = determinant(matrix) < 0 ? 1 : 0;
      const outward = cofactors(matrix).map((x) => (turn === 1 ? -x : x));
      for (let at = 0; at < positions.length; at += 3) {
        found.positions.push(...moved(matrix, positions.slice(at, at + 3), 1));
        found.normals.push(...moved(outward, normals.slice(at, at + 3), 0));
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
    throw error instanceof Refusal ? error : damaged();
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

/** A point (w is 1) or a direction (0) by a matrix. */
function moved(matrix: readonly number[], point: number[], w: number): number[] {
  return [0, 1, 2].map((row) =>
    point.reduce((sum, x, k) => sum + matrix[4 * k + row]! * x, w * matrix[12 + row]!),
  );
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

function damaged(): Refusal {
  return new Refusal("It is damaged or no mesh that the page can read.");
}
