/** The core in a worker: `new Worker(new URL("../core/worker.ts", import.meta.url))`, of a module. */

import { Server } from "./server";

const tasks: (() => void)[] = [];
const channel = new MessageChannel();
channel.port1.onmessage = () => tasks.shift()?.();

const server = new Server({
  post: (response, transfer) => postMessage(response, { transfer }),
  // A message to itself is not delayed as repeated timers are.
  defer: (task) => {
    tasks.push(task);
    channel.port2.postMessage(null);
  },
});

addEventListener("message", (event: MessageEvent) => server.receive(event.data));
