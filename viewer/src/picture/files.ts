/** What needs no networks, in a worker of its own: files of meshes and pictures, and occlusion. */

import { occlusion } from "../core/occlusion";
import { serve } from "../core/rpc";
import { readExr } from "./exr_file";
import { readMesh } from "./mesh_files";

const calls = { occlusion, readMesh, readExr };

export type FileCalls = typeof calls;

serve(calls);
