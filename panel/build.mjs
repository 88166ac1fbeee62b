// Bundles the page into one folder: index.html, panel.js, panel.css. Usage: node build.mjs [FOLDER]
import * as esbuild from "esbuild";
import { copyFileSync, mkdirSync, readFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { join } from "node:path";

const BUDGET_BYTES = 500_000; // of all files, compressed
const here = import.meta.dirname;
const folder = process.argv[2] ?? join(here, "dist");
mkdirSync(folder, { recursive: true });
await esbuild.build({
  entryPoints: [join(here, "src/panel.ts")], outfile: join(folder, "panel.js"), bundle: true, minify: true,
  format: "esm", target: "es2022", legalComments: "linked", logLevel: "warning",
});
copyFileSync(join(here, "index.html"), join(folder, "index.html"));
const bytes = ["index.html", "panel.js", "panel.css"].map((file) => gzipSync(readFileSync(join(folder, file))).length).reduce((a, b) => a + b);
console.log(`panel: ${bytes} bytes compressed, of ${BUDGET_BYTES}`);
if (bytes > BUDGET_BYTES) {
  console.error("panel: too large. Remove what is not needed");
  process.exit(1);
}
