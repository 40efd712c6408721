// The template in the repository is what its sources make.
import { spawnSync } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";

const page = join(process.argv[2], "stages/report/page");
if (!existsSync(join(page, "node_modules/esbuild"))) {
  console.log("skipped: the page's packages are not installed; npm ci in stages/report/page");
  process.exit(77);
}
for (const [program, ...rest] of [["build.mjs", "--check"], ["node_modules/typescript/bin/tsc", "--noEmit"]]) {
  const { status } = spawnSync(process.execPath, [program, ...rest], { cwd: page, stdio: "inherit" });
  if (status !== 0) process.exit(1);
}
