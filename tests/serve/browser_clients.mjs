// Clients of the streams that nobody of takt wrote: ws and @foxglove/ws-protocol of npm, and Chromium's own WebSocket.
// By hand, as it needs npm and a browser:
//   mkdir -p build/npm && npm install --prefix build/npm ws @foxglove/ws-protocol
//   node tests/serve/browser_clients.mjs build/release/tools/takt build/npm [chromium]
import { spawn } from "node:child_process";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

const [takt, packages, chromium = "chromium"] = process.argv.slice(2);
const require = createRequire(path.resolve(packages, "node_modules", "x"));
const WebSocket = require("ws");
const { FoxgloveClient } = require("@foxglove/ws-protocol");

const PATIENCE_MS = 20000;
const later = (promise, what) =>
  Promise.race([promise, new Promise((_, reject) => setTimeout(() => reject(new Error(`too late: ${what}`)), PATIENCE_MS).unref())]);

// What a client of takt.v1 does with any WebSocket: greets, takes events in order and frames of values without gaps.
const talk = (socket) =>
  new Promise((resolve, reject) => {
    let frames = 0;
    socket.binaryType = "arraybuffer";
    socket.onerror = () => reject(new Error("the connection has an error"));
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") {
        const message = JSON.parse(data);
        if (message.op === "problem") reject(new Error(data));
        if (message.op === "hello") {
          socket.send(JSON.stringify({ op: "events", from: 1 }));
          socket.send(JSON.stringify({ op: "monitor", id: 7, arm: "arm", value: "q_measured", every: 10 }));
        }
        return;
      }
      const frame = new DataView(data);
      if (frame.getUint32(4, true) !== frames + 1) reject(new Error("frames have gaps"));
      frames += 1;
      socket.send(JSON.stringify({ op: "ack", frame: frames }));
      if (frames === 50) resolve(frames);
    };
  });

const page = (url) => `<!doctype html><script type="module">
const talk = ${talk.toString()};
const answer = await talk(new WebSocket(${JSON.stringify(url)}, "takt.v1")).then((frames) => ({ frames }), (error) => ({ error: error.message }));
await fetch("/result", { method: "POST", body: JSON.stringify(answer) });
</script>`;

let shown = "";
let answered;
const answer = new Promise((resolve) => (answered = resolve));
const pages = createServer((request, response) => {
  if (request.method === "GET") return response.writeHead(200, { "Content-Type": "text/html" }).end(shown);
  let body = "";
  request.on("data", (chunk) => (body += chunk)).on("end", () => (response.end(), answered(JSON.parse(body))));
});
await new Promise((resolve) => pages.listen(0, "127.0.0.1", resolve));
const origin = `http://127.0.0.1:${pages.address().port}`;

const server = spawn(takt, ["serve", "scenarios/touch.json", "--port", "0", "--origin", origin], { stdio: ["ignore", "ignore", "pipe"] });
const port = await later(
  new Promise((resolve) => {
    let text = "";
    server.stderr.on("data", (chunk) => {
      text += chunk;
      const found = /http:\/\/127\.0\.0\.1:(\d+)/.exec(text);
      if (found) resolve(found[1]);
    });
  }),
  "the server",
);
const url = `ws://127.0.0.1:${port}/v1/stream`;
const profile = mkdtempSync(path.join(tmpdir(), "takt_chromium_"));
let failed = false;
const check = async (name, work) => {
  try {
    console.log(`${name}: ${await later(work(), name)}`);
  } catch (error) {
    failed = true;
    console.log(`${name}: FAILED: ${error.message}`);
  }
};

await check("ws", async () => {
  const socket = new WebSocket(url, "takt.v1");
  const frames = await talk(socket);
  socket.close();
  return `${frames} frames without gaps`;
});
await check("@foxglove/ws-protocol", async () => {
  const client = new FoxgloveClient({ ws: new WebSocket(`ws://127.0.0.1:${port}/`, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
  const topics = new Map();
  const seen = new Set();
  await new Promise((resolve, reject) => {
    client.on("error", reject);
    client.on("advertise", (channels) => {
      for (const channel of channels) topics.set(client.subscribe(channel.id), channel.topic);
    });
    client.on("message", ({ subscriptionId, data }) => {
      if (data.byteLength > 0) seen.add(topics.get(subscriptionId));
      if (["/tf", "/scene", "/arm/joint_states"].every((topic) => seen.has(topic))) resolve();
    });
  });
  client.close();
  return `messages of ${[...seen].sort().join(", ")}`;
});
await check("Chromium", async () => {
  shown = page(url);
  const browser = spawn(chromium, ["--headless=new", "--no-sandbox", "--disable-gpu", `--user-data-dir=${profile}`, `${origin}/`], { stdio: "ignore" });
  try {
    const { frames, error } = await answer;
    if (error) throw new Error(error);
    return `${frames} frames without gaps`;
  } finally {
    browser.kill();
    await new Promise((resolve) => browser.once("exit", resolve));
  }
});

server.kill("SIGINT");
pages.close();
rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
process.exit(failed ? 1 : 0);
