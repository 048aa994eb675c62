/** The core in a worker. */

import { coreCalls } from "./calls";
import { serve } from "./rpc";

serve(coreCalls());
