/** What needs no networks, in a worker of its own: files of meshes and pictures, and occlusion. */

import { occlusion } from "../core/occlusion";
import { serve } from "../core/rpc";
import { readMesh } from "./mesh_files";
import { readPanorama } from "./picture_files";

const calls = { occlusion, readMesh, readPanorama };

export type FileCalls = typeof calls;

serve(calls);
