// What the page costs and how fast it is, in a real Chromium before a real takt: size, time until it is usable,
// pictures a second and their age while arms move, and what the core noticed of it. Figures: docs/benchmarks.md.
// Usage: node bench/panel.mjs [SCENARIO] [SECONDS]   (TAKT=... names another program)
import { readdirSync, statSync } from "node:fs";
import { launch, open, Takt } from "../tests/panel/support.mjs";

const [scenario = "scenarios/carry.json", seconds = "15"] =
  process.argv.slice(2);
const DIST = "panel/dist";

/** In the page: when pictures were begun, and how old the newest pose was then. */
function watch() {
  const seen = { pictures: [], ages: [], offsets: [], pose: 0 };
  globalThis.benchmark = seen;
  const fence = WebGL2RenderingContext.prototype.fenceSync;
  WebGL2RenderingContext.prototype.fenceSync = function (...given) {
    const now = performance.now();
    seen.pictures.push(now);
    if (seen.pose) seen.ages.push(now - seen.pose - Math.min(...seen.offsets));
    return fence.apply(this, given);
  };
  const add = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage");
  Object.defineProperty(WebSocket.prototype, "onmessage", {
    set(listener) {
      add.set.call(this, (event) => {
        if (event.data instanceof ArrayBuffer) {
          const view = new DataView(event.data);
          if (view.getUint8(0) === 2) {
            seen.pose = 1000 * view.getFloat64(16, true);
            // The cell's clock and the page's differ by this, as the fastest pose of the last second says: cycles that
            // are late set the cell's clock back.
            seen.offsets.push(performance.now() - seen.pose);
            if (seen.offsets.length > 30) seen.offsets.shift();
          }
        }
        listener(event);
      });
    },
  });
}

const quantile = (values, q) =>
  [...values].sort((a, b) => a - b)[Math.floor(q * (values.length - 1))] ?? NaN;
const bytes = readdirSync(DIST)
  .filter((file) => file.endsWith(".gz"))
  .reduce((sum, file) => sum + statSync(`${DIST}/${file}`).size, 0);

const server = await Takt.start("run", scenario, "--panel");
const browser = await launch();
const page = await open(browser, "about:blank", {
  viewport: { width: 1700, height: 1060 },
}); // the 3D view has about 1280x720
await page.addInitScript(watch);
const began = Date.now();
await page.goto(server.url);
await page.getByRole("button", { name: "Start", exact: true }).click();
const usable = Date.now() - began;
const before = await server.ask("GET", "/v1/state");
await page.evaluate(() => {
  benchmark.pictures = [];
  benchmark.ages = [];
});
await page.waitForTimeout(1000 * Number(seconds));
const seen = await page.evaluate(() => benchmark);
const after = await server.ask("GET", "/v1/state");
const scene = await server.ask("GET", "/v1/scene");
const { width, height } = await page.locator("#view canvas").boundingBox();
console.log(
  JSON.stringify({
    scenario,
    page_kB_packed: Math.round(bytes / 1000),
    usable_ms: usable,
    triangles: scene.meshes.reduce((sum, mesh) => sum + mesh.triangles, 0),
    view: `${Math.round(width)}x${Math.round(height)}`,
    pictures_per_s: Number((seen.pictures.length / Number(seconds)).toFixed(1)),
    age_ms: {
      p50: Math.round(quantile(seen.ages, 0.5)),
      p99: Math.round(quantile(seen.ages, 0.99)),
    },
    cycles: after.cycle - before.cycle,
    late_cycles: after.health.overruns - before.health.overruns,
  }),
);
await browser.close();
await server.end();
