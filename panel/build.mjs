// Bundles the page into one folder: index.html, panel.js, panel.css, icon.svg, the licences of what is in it, and each
// of them packed. Usage: node build.mjs [FOLDER]
import * as esbuild from "esbuild";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const BUDGET_BYTES = 500_000; // of all files, packed
const here = dirname(fileURLToPath(import.meta.url));
const folder = process.argv[2] ?? join(here, "dist");

/** Names of the packages from which something is in the bundle. */
function packagesOf(metafile) {
  const names = Object.keys(metafile.inputs).map((file) => /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file)?.[1]);
  return [...new Set(names.filter(Boolean))].sort();
}

function licenceOf(name) {
  const root = join(here, "node_modules", name);
  const { version, license } = JSON.parse(readFileSync(join(root, "package.json"), "utf8"));
  const text = ["LICENSE", "LICENSE.md", "LICENSE.txt"].map((file) => join(root, file)).find(existsSync);
  if (!text) throw new Error(`${name} has no licence text`);
  return `${name} ${version} (${license})\n\n${readFileSync(text, "utf8").trim()}\n`;
}

const result = await esbuild.build({
  entryPoints: [join(here, "src/panel.ts")],
  outfile: join(folder, "panel.js"),
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  logLevel: "warning",
  metafile: true,
  write: false,
});
const files = new Map(
  result.outputFiles.map((file) => [file.path.endsWith(".css") ? "panel.css" : "panel.js", file.contents]),
);
files.set("index.html", readFileSync(join(here, "index.html")));
files.set("icon.svg", readFileSync(join(here, "icon.svg")));
files.set(
  "licences.txt",
  Buffer.from(
    packagesOf(result.metafile)
      .map(licenceOf)
      .join(`\n${"-".repeat(80)}\n\n`),
  ),
);

const packed = new Map([...files].map(([name, bytes]) => [name, gzipSync(bytes, { level: 9 })]));
const bytes = [...packed.values()].reduce((sum, one) => sum + one.length, 0);
if (bytes > BUDGET_BYTES) {
  console.error(`panel: ${bytes} bytes packed, of ${BUDGET_BYTES}. Remove what is not needed`);
  process.exit(1);
}
mkdirSync(folder, { recursive: true });
for (const [name, contents] of files) {
  writeFileSync(join(folder, name), contents);
  writeFileSync(join(folder, `${name}.gz`), packed.get(name));
}
console.log(`panel: ${bytes} bytes packed, of ${BUDGET_BYTES}`);
