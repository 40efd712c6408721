// Builds dist/template.html: styles and program in one file. `node build.mjs --check` builds in memory and fails where
// the file in the repository differs.
import { build } from "esbuild";
import { readFileSync, writeFileSync, mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const common = { bundle: true, minify: true, write: false, target: "es2022", legalComments: "eof", absWorkingDir: here };

// The worker is text inside the program: a page opened from disk may not load a second file.
const worker = await build({ ...common, entryPoints: ["src/worker.ts"], format: "iife" });
const program = await build({
  ...common,
  entryPoints: ["src/main.ts"],
  format: "iife",
  define: { WORKER_TEXT: JSON.stringify(worker.outputFiles[0].text) },
});
const style = await build({ ...common, entryPoints: ["src/page.css"] });
const html = readFileSync(join(here, "src/page.html"), "utf8")
  .replace("/*STYLE*/", () => style.outputFiles[0].text.trim())
  .replace("/*PROGRAM*/", () => program.outputFiles[0].text.trim());

const target = join(here, "dist/template.html");
if (process.argv.includes("--check")) {
  if (readFileSync(target, "utf8") !== html) {
    console.error("dist/template.html is not what src makes; run `npm ci && npm run build` in stages/report/page");
    process.exit(1);
  }
} else {
  mkdirSync(dirname(target), { recursive: true });
  writeFileSync(target, html);
  console.log(`${target}: ${(html.length / 1024).toFixed(0)} KiB`);
}
