/** The core in a worker. */

import { coreCalls } from "./calls";
import { serve } from "./rpc";

// A message to itself is not delayed as repeated timers are.
const channel = new MessageChannel();
const waiting: (() => void)[] = [];
channel.port1.onmessage = () => waiting.shift()?.();
const pause = () =>
  new Promise<void>((resolve) => {
    waiting.push(resolve);
    channel.port2.postMessage(null);
  });

serve({ ...coreCalls(pause) });
