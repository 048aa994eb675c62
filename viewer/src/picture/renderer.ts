/** Draws the object with one or two materials, and gathers frames until the picture is smooth. */

import type { Occlusion } from "../core/occlusion";
import materialSource from "../printed/material.glsl?raw";
import { type EnvironmentName, TONES } from "../state/state";
import { type Camera, cameraOf, mirrored } from "./camera";
import { EnvironmentMap, lightsOf, SIDE } from "./environment";
import { contextOf, type Gl, included, Program, type Target } from "./gl";
import { Ground } from "./ground";
import { groundSize, type Mesh, meshOf, VERTEX_NUMBERS } from "./meshes";
import { type Light, type LitPanorama, uniformsOf } from "./panorama";
import anisotropicSource from "./shaders/anisotropic.glsl?raw";
import backdropSource from "./shaders/backdrop.frag?raw";
import basisSource from "./shaders/basis.glsl?raw";
import blendSource from "./shaders/blend.frag?raw";
import displaySource from "./shaders/display.frag?raw";
import frameSource from "./shaders/frame.glsl?raw";
import objectFragment from "./shaders/object.frag?raw";
import objectVertex from "./shaders/object.vert?raw";
import paintSource from "./shaders/paint.frag?raw";
import surfaceSource from "./shaders/surface.frag?raw";
import { around, type Box, panes, type Shot, shiftOf, WHOLE } from "./shot";
import { ShownMaterial } from "./shown_material";
import { Targets } from "./targets";

const OBJECT_SOURCE = included(objectFragment, {
  "frame.glsl": frameSource,
  "material.glsl": materialSource,
  "anisotropic.glsl": included(anisotropicSource, { "basis.glsl": basisSource }),
});

/** Width and directions of the blurred image in the ground, relative to the object's, and its margin. */
const [MIRROR_SCALE, MIRROR_SHARE, MIRROR_MARGIN] = [0.5, 0.25, 4];

export class Renderer {
  private readonly gl: Gl;
  private readonly object: Program;
  /** That of anisotropic materials; compiled when it is first needed. */
  private anisotropic: Program | null = null;
  private readonly surface: Program;
  private readonly paint: Program;
  private readonly backdrop: Program;
  private readonly blend: Program;
  private readonly display: Program;
  readonly map: EnvironmentMap;
  readonly targets: Targets;
  private readonly ground: Ground;
  private readonly array: WebGLVertexArrayObject;
  private readonly slots: (ShownMaterial | undefined)[] = [];
  private readonly buffers: [WebGLBuffer, WebGLBuffer, WebGLBuffer, WebGLBuffer];
  private mesh: Mesh;
  private lights: Light[] = [];
  private isPanorama = false;

  /** @throws NoGraphics */
  constructor(readonly canvas: HTMLCanvasElement) {
    const gl = contextOf(canvas);
    this.gl = gl;
    gl.depthFunc(gl.LEQUAL); // what lies at the far plane is drawn where nothing hides it
    this.object = new Program(gl, OBJECT_SOURCE);
    const surfaceOfBasis = included(surfaceSource, { "basis.glsl": basisSource });
    this.surface = new Program(gl, surfaceOfBasis, {}, objectVertex);
    this.paint = new Program(gl, paintSource, {}, objectVertex);
    this.backdrop = new Program(gl, backdropSource);
    this.blend = new Program(gl, blendSource);
    this.display = new Program(gl, displaySource);
    this.map = new EnvironmentMap(gl, this.isSoftware);
    this.targets = new Targets(gl);
    this.ground = new Ground(gl);
    this.array = gl.createVertexArray()!;
    const buffer = () => gl.createBuffer()!;
    this.buffers = [buffer(), buffer(), buffer(), buffer()];
    this.mesh = meshOf("ball");
    this.uploadMesh();
  }

  setMesh(mesh: Mesh): void {
    if (mesh === this.mesh) return;
    this.mesh = mesh;
    this.ground.setShadows(new Uint8Array(0));
    this.uploadMesh();
  }

  /** Take over the `occlusion` of the mesh; until then it hides none of its light. */
  setOcclusion({ openings, shadows }: Occlusion): void {
    const { gl } = this;
    this.ground.setShadows(shadows);
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[3]);
    gl.bufferData(gl.ARRAY_BUFFER, openings, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(4);
    gl.vertexAttribPointer(4, 4, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
  }

  /** Draw the environment of a name, or a panorama and the lights that were taken out of it. */
  setEnvironment(name: EnvironmentName, own: LitPanorama | null): void {
    this.isPanorama = name === "own" && own !== null;
    if (own !== null && this.isPanorama) {
      this.map.drawPanorama(own.panorama);
      this.lights = own.lights;
    } else {
      this.map.drawFormula(name);
      this.lights = lightsOf(name);
    }
    this.ground.changed();
  }

  /** The material of a slot, which is drawn once it has a table. */
  material(slot: 0 | 1): ShownMaterial {
    this.slots[slot] ??= new ShownMaterial(this.gl);
    return this.slots[slot];
  }

  /** Whether the processor draws, which is hundreds of times slower. */
  get isSoftware(): boolean {
    const { gl } = this;
    const names = gl.getExtension("WEBGL_debug_renderer_info");
    const name = names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
    return /swiftshader|llvmpipe|software|basic render/i.test(name);
  }

  /** Number of pixels that a frame of the canvas's size has; two pictures make a difference. */
  pixels({ comparison }: Shot): number {
    return this.canvas.width * this.canvas.height * (comparison === "difference" ? 2 : 1);
  }

  /**
   * Draw a frame; it pauses wherever a part that takes long has been drawn.
   *
   * @param count frames gathered so far.
   * @param scale width of the shading relative to the canvas.
   * @param share share of the directions that is taken, in (0, 1].
   * @param strips parts of the shading.
   */
  *drawFrame(
    shot: Shot,
    count: number,
    scale: number,
    share: number,
    strips: number,
  ): Generator<void> {
    const { gl, targets, mesh } = this;
    const { height } = this.canvas;
    const partWidth = this.canvas.width;
    targets.resize(shot.comparison === "difference" ? 2 * partWidth : partWidth, height, scale);
    this.ground.light(this.map, this.lights, turnOf(shot), mesh.width / groundSize(mesh));
    const { count: parts, column, row } = shot.part ?? WHOLE;
    for (const pane of panes(shot, parts * partWidth, partWidth)) {
      const material = this.slots[pane.slot];
      const inPart = (x: number) => Math.min(Math.max(x - column * partWidth, 0), partWidth);
      const [left, right] = [inPart(pane.from), inPart(pane.to)];
      if (!material || left === right) continue;
      const start = pane.offset + pane.x - column * partWidth;
      const place: Box = [start, -row * height, pane.width, parts * height];
      const clip: Box = [pane.offset + left, 0, right - left, height];
      // Frames are shifted by parts of a pixel, of the frame as of the shading, for smooth edges.
      const shift = shiftOf(count);
      const seenFrom = ([, , wide, tall]: Box) =>
        cameraOf(mesh, shot.view, pane.width / (parts * height), [
          (2 * shift[0]) / wide,
          (2 * shift[1]) / tall,
        ]);
      /** Draw into a part from here on, which is emptied. */
      const begin = (target: Target, box: Box, part: Box) => {
        target.bind();
        gl.enable(gl.SCISSOR_TEST);
        gl.viewport(...box);
        gl.scissor(...part);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      };
      const camera = seenFrom(place);
      const images = [MIRROR_SCALE * Math.max(scale, 0.5), scale].map((size, k) => {
        const coarse = place.map((x) => Math.round(x * size)) as Box;
        const ratio = [coarse[2] / place[2], coarse[3] / place[3]] as const;
        const from = [0, 1].map((k) => coarse[k] + shift[k] - (place[k] + shift[k]) * ratio[k]);
        const margin = k === 1 ? 2 : MIRROR_MARGIN;
        return { coarse, part: around(clip, size, margin), map: [...from, ...ratio] };
      });
      const isAbove = camera.eye[2] > 0;
      for (const [isMirrored, { coarse, part }] of [true, false].map(
        (x, k) => [x, images[k]] as const,
      )) {
        if (isMirrored && !isAbove) continue;
        const from = isMirrored ? mirrored(seenFrom(coarse)) : seenFrom(coarse);
        begin(targets.surface, coarse, part);
        gl.frontFace(isMirrored ? gl.CW : gl.CCW);
        const toTexture = material.codes?.texture.toTexture ?? [0, 0, 0, 0, 0, 0];
        this.surface.use({ projection: from.projection, toTexture });
        this.drawMesh();
        gl.frontFace(gl.CCW);
        const [x, y, wide, tall] = part;
        const many = isMirrored ? Math.ceil(strips / 4) : strips;
        for (let strip = 0; strip < many; strip++) {
          const [low, high] = [strip, strip + 1].map((k) => Math.round((tall * k) / many));
          const target = isMirrored ? targets.mirror : targets.shaded;
          begin(target, coarse, [x, y + low!, wide, high! - low!]);
          const fade = isMirrored ? 0.7 * mesh.halfHeight : 0;
          this.shade(from, shot, material, count, isMirrored ? MIRROR_SHARE * share : share, fade);
          gl.disable(gl.SCISSOR_TEST);
          if (strips > 1) yield;
        }
      }
      begin(targets.many, place, clip);
      this.drawPaint(camera, images[1].map);
      this.drawBackdrop(camera, shot, isAbove ? images[0].map : null);
      gl.disable(gl.SCISSOR_TEST);
    }
    this.gather(shot, count);
  }

  /** Gather the frame, of which `count` precede it, and show the mean. */
  private gather(shot: Shot, count: number): void {
    const { gl, targets } = this;
    targets.resolve();
    targets.mean.bind();
    // The later frames, whose levels are finer, weigh more.
    gl.blendColor(0, 0, 0, 2 / (count + 2));
    if (count > 0) gl.enable(gl.BLEND);
    gl.blendFunc(gl.CONSTANT_ALPHA, gl.ONE_MINUS_CONSTANT_ALPHA);
    this.blend.cover({ frame: targets.frame.textures[0] });
    gl.disable(gl.BLEND);
    this.show(shot);
  }

  /** Draw and show one frame at once. */
  draw(shot: Shot, scale = 1, share = 1): void {
    this.drawFrame(shot, 0, scale, share, 1).next();
  }

  /** Show what has been gathered. */
  show(shot: Shot): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    this.drawDisplay(shot, shot.comparison === "difference" ? shot.scale : 0);
  }

  /** Draw what has been gathered as it is shown; scale: see display.frag. */
  private drawDisplay({ exposure, tone, background }: Shot, scale: number): void {
    const isPlain = background.startsWith("#");
    const bytes = [1, 3, 5].map((at) => Number.parseInt(background.slice(at, at + 2), 16));
    this.display.cover({
      picture: this.targets.mean.textures[0],
      exposure: 2 ** exposure,
      tone: TONES.indexOf(tone),
      behind: isPlain ? [...bytes.map((x) => x / 255), 1] : [0, 0, 0, 0],
      scale,
    });
  }

  /** The mean colour difference (CIELAB) of pixels that differ, and the largest. */
  difference(shot: Shot): { mean: number; largest: number } {
    const { gl } = this;
    const { frame } = this.targets;
    const width = frame.width >> 1;
    frame.bind();
    gl.viewport(0, 0, width, frame.height);
    this.drawDisplay(shot, -1);
    let [sum, count, largest] = [0, 0, 0];
    const values = frame.read(width);
    for (let at = 0; at < values.length; at += 3)
      if (values[at] > 0) {
        sum += values[at];
        count++;
        largest = Math.max(largest, values[at]);
      }
    return { mean: sum / Math.max(count, 1), largest };
  }

  /** A promise of the time that the commands so far have taken [ms]. */
  async finished(): Promise<number> {
    const { gl } = this;
    const start = performance.now();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    if (fence === null) return 0;
    while (!gl.isContextLost()) {
      const status = gl.clientWaitSync(fence, 0, 0);
      if (status === gl.ALREADY_SIGNALED || status === gl.CONDITION_SATISFIED) break;
      if (status === gl.WAIT_FAILED) break;
      // Questions cost as well, the more the slower the machine is.
      const wait = Math.min(2 + 0.1 * (performance.now() - start), 50);
      await new Promise((resolve) => setTimeout(resolve, wait));
    }
    gl.deleteSync(fence);
    return performance.now() - start;
  }

  /** Whether the graphics driver has taken the context away, so that nothing is drawn any more. */
  get isLost(): boolean {
    return this.gl.isContextLost();
  }

  /** Give the graphics memory back. */
  dispose(): void {
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** @param toMirror from pixels to the mirror image in the ground; null: there is none. */
  private drawBackdrop(camera: Camera, shot: Shot, toMirror: number[] | null): void {
    const { gl, backdrop, mesh, map, isPanorama } = this;
    // The object hides a part of it, which thus costs nothing.
    gl.enable(gl.DEPTH_TEST);
    backdrop.cover({
      ...camera,
      turn: turnOf(shot),
      isPlain: shot.background !== "environment",
      isPanorama,
      size: [mesh.width, groundSize(mesh)],
      toMirror: toMirror ?? [0, 0, 0, 0],
      environment: map.texture,
      irradiance: map.irradiance,
      ground: this.ground.texture,
      mirror: this.targets.mirror.textures[0],
    });
    gl.disable(gl.DEPTH_TEST);
  }

  /** Draw the mesh in the colours that were computed; toShaded: from pixels to them. */
  private drawPaint({ projection }: Camera, toShaded: number[]): void {
    const { gl, targets } = this;
    const shaded = targets.shaded.textures[0];
    const near = 0.02 * this.mesh.radius;
    this.paint.use({ projection, shaded, ...targets.uniforms, toShaded, near });
    gl.enable(gl.CULL_FACE);
    gl.polygonOffset(2, 2);
    gl.cullFace(gl.BACK);
    this.drawMesh();
    // Backs lie behind: at the contour, where both meet, they would be dark dots.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.cullFace(gl.FRONT);
    this.drawMesh();
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.CULL_FACE);
  }

  private drawMesh(): void {
    const { gl } = this;
    gl.bindVertexArray(this.array);
    gl.enable(gl.DEPTH_TEST);
    gl.drawElements(gl.TRIANGLES, this.mesh.faces.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
  }

  /** Compute the colours of the surface that has been drawn. */
  private shade(
    { eye }: Camera,
    shot: Shot,
    material: ShownMaterial,
    count: number,
    share: number,
    fade: number,
  ): void {
    const { map } = this;
    const program = material.texels?.program ?? this.programOf(material);
    program.cover({
      ...material.uniforms(count, share),
      ...this.targets.uniforms,
      ...uniformsOf(this.lights),
      eye,
      turn: turnOf(shot),
      side: SIDE,
      fade,
      environment: map.texture,
      irradiance: map.irradiance,
    });
  }

  /** The program that draws a table. */
  private programOf({ isAnisotropic }: ShownMaterial): Program {
    if (!isAnisotropic) return this.object;
    this.anisotropic ??= new Program(this.gl, OBJECT_SOURCE, { ANISOTROPIC: 1 });
    return this.anisotropic;
  }

  private uploadMesh(): void {
    const { gl } = this;
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, this.mesh.vertices, gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers[1]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, this.mesh.faces, gl.STATIC_DRAW);
    [3, 3, 2].forEach((count, place) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, gl.FLOAT, false, 4 * VERTEX_NUMBERS, 12 * place);
    });
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[2]);
    gl.bufferData(gl.ARRAY_BUFFER, this.mesh.tangents, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(3);
    gl.vertexAttribPointer(3, 3, gl.FLOAT, false, 0, 0);
    gl.disableVertexAttribArray(4);
    gl.vertexAttrib4f(4, 0, 0, 0, 1);
    gl.bindVertexArray(null);
  }
}

function turnOf(shot: Shot): [number, number] {
  const angle = (shot.rotation * Math.PI) / 180;
  return [Math.cos(angle), Math.sin(angle)];
}
