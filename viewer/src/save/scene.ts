/** What the page shows as a scene of Mitsuba 3: an archive of XML, mesh, environment and material. */

import { cameraOf } from "../picture/camera";
import type { Mesh } from "../picture/meshes";
import type { Light } from "../picture/panorama";
import type { View } from "../state/state";
import { plyFile } from "./ply";
import { zipFile } from "./zip";

/** What the camera sees. */
export interface Scene {
  mesh: Mesh;
  view: View;
  /** Rotation of the environment [degrees]. */
  rotation: number;
  /** Size of the picture [pixels]. */
  width: number;
  height: number;
  /** A picture of the environment, without the lights that stand beside it. */
  environment: { suffix: "hdr" | "exr"; bytes: Uint8Array };
  lights: readonly Light[];
  /** A file of the plugin `neural_brdf`. */
  material: Uint8Array;
}

/** The archive; `mitsuba` itself needs `import urushi` before it can load the scene. */
export function sceneFile(scene: Scene): Uint8Array<ArrayBuffer> {
  const { mesh } = scene;
  return zipFile({
    "scene.xml": new TextEncoder().encode(sceneXml(scene)),
    "object.ply": plyFile(mesh),
    [`environment.${scene.environment.suffix}`]: scene.environment.bytes,
    "material.safetensors": scene.material,
  });
}

/** The scene's text. */
function sceneXml(scene: Scene): string {
  const { mesh, view, rotation, width, height, environment } = scene;
  const { eye, up, forward } = cameraOf(mesh, view, width / height);
  const target = eye.map((x, k) => x + forward[k]);
  const fov = (360 / Math.PI) * Math.atan(Math.hypot(...up));
  return `<scene version="3.0.0">
    <default name="spp" value="256"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <string name="fov_axis" value="y"/>
        <float name="fov" value="${fov}"/>
        <transform name="to_world">
            <lookat origin="${eye.join(", ")}" target="${target.join(", ")}" up="${up.join(", ")}"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="${width}"/>
            <integer name="height" value="${height}"/>
            <string name="pixel_format" value="rgb"/>
            <rfilter type="box"/>
        </film>
        <sampler type="independent">
            <integer name="sample_count" value="$spp"/>
        </sampler>
    </sensor>
    <emitter type="envmap" id="environment">
        <string name="filename" value="environment.${environment.suffix}"/>
        <transform name="to_world">
            <rotate x="1" angle="90"/>
            <rotate z="1" angle="${rotation}"/>
        </transform>
    </emitter>
${scene.lights.map((light) => lightXml(light, rotation)).join("")}\
    <shape type="ply" id="object">
        <string name="filename" value="object.ply"/>
        <bsdf type="neural_brdf">
            <string name="filename" value="material.safetensors"/>
        </bsdf>
    </shape>
</scene>
`;
}

function lightXml({ direction, power }: Light, rotation: number): string {
  const way = direction.map((x) => -x).join(", ");
  return `    <emitter type="directional">
        <rgb name="irradiance" value="${power.join(", ")}"/>
        <transform name="to_world">
            <lookat origin="0, 0, 0" target="${way}" up="0.36, 0.48, 0.8"/>
            <rotate z="1" angle="${rotation}"/>
        </transform>
    </emitter>
`;
}
